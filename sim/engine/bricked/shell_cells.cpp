// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/bricked/shell_cells.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "sim/base/geometry.h"

namespace reamsim {

// The struct has the same layout on host and device.
static_assert(sizeof(ShellCell) == 32);

namespace {

constexpr int kLargestSide = 1 << RS_CELL_BITS;
constexpr std::size_t kLanes = 16;
/// The window less three voxels for the rounding of its corner, one for the voxel of the last point, and a slack for
/// the rounding of fixed-point steps.
constexpr double kWindowVoxels = 32 - 4 - 0.01;

ShellCell bounds_of(const std::vector<Vec3i>& points) {
  Vec3i low = points.front(), high = points.front();
  for (const Vec3i& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vec3i span = high - low;
  return {{low.x(), low.y(), low.z()}, {span.x(), span.y(), span.z()}, 0, 0};
}

std::uint16_t offset_of(const Vec3i& point, const ShellCell& cell) {
  return static_cast<std::uint16_t>((point.x() - cell.first[0]) | (point.y() - cell.first[1]) << RS_CELL_BITS |
                                    (point.z() - cell.first[2]) << (2 * RS_CELL_BITS));
}

void append_cell(ShellCells& out, const std::vector<Vec3i>& points) {
  ShellCell cell = bounds_of(points);
  cell.begin = static_cast<rs_u32>(out.offsets.size());
  cell.count = static_cast<rs_u32>(points.size());
  for (const Vec3i& p : points) out.offsets.push_back(offset_of(p, cell));
  while (out.offsets.size() % kLanes != 0) out.offsets.push_back(out.offsets.back());
  out.cells.push_back(cell);
}

/// The bounds of a run are those of its cells' corners.
void append_runs(ShellCells& out) {
  for (std::size_t begin = 0; begin < out.cells.size(); begin += kRunCells) {
    const std::size_t end = std::min(out.cells.size(), begin + kRunCells);
    std::vector<Vec3i> corners;
    for (std::size_t c = begin; c < end; ++c) {
      const Vec3i first(out.cells[c].first);
      corners.push_back(first);
      corners.push_back(first + Vec3i(out.cells[c].span));
    }
    ShellCell run = bounds_of(corners);
    run.begin = static_cast<rs_u32>(begin);
    run.count = static_cast<rs_u32>(end - begin);
    out.runs.push_back(run);
  }
}

}  // namespace

int shell_cell_side(double shell_cell_voxels) {
  int side = kLargestSide;
  // The largest extent along an axis is the block's diagonal.
  while (side > 1 && (side - 1) * shell_cell_voxels * std::sqrt(3.0) > kWindowVoxels) side /= 2;
  return side;
}

ShellCells make_shell_cells(const PointShell& shell, int side) {
  ShellCells out;
  const int shift = 3 * std::countr_zero(static_cast<unsigned>(side));
  std::vector<Vec3i> points;
  for (std::size_t i = 0; i < shell.codes.size(); ++i) {
    points.push_back(morton_decode(shell.codes[i]));
    const bool last = i + 1 == shell.codes.size() || shell.codes[i + 1] >> shift != shell.codes[i] >> shift;
    if (!last) continue;
    append_cell(out, points);
    points.clear();
  }
  append_runs(out);
  return out;
}

}  // namespace reamsim
