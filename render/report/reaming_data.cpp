// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <utility>

#include "render/gl/camera.h"
#include "render/report/markup.h"
#include "render/report/mesh_data.h"
#include "render/report/page_data.h"
#include "sim/base/parallel.h"
#include "sim/record/snapshot.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMaxStates = 12;
constexpr double kStep_voxels = 0.5;

/// Fraction of bone in the voxels round a point, interpolated between their centres.
double bone_at(const Voxmap& voxmap, const FillBricks& fill, const Vec3& point_mm) {
  const Vec3 place = (point_mm - voxmap.grid.origin_mm) / voxmap.grid.voxel_mm - Vec3::Constant(0.5);
  const Vec3i low = place.array().floor().cast<int>();
  const Vec3 part = place - low.cast<double>();
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3i side(corner & 1, corner >> 1 & 1, corner >> 2);
    const Vec3i voxel = low + side;
    if (!voxmap.grid.contains(voxel) || voxmap.grade.get(voxel) == 0) continue;
    double weight = fill.get(voxel);
    for (int axis = 0; axis < 3; ++axis) weight *= side[axis] == 1 ? part[axis] : 1 - part[axis];
    sum += weight;
  }
  return sum / FillBricks::kWhole;
}

/// The rays along which bone was removed from the reamed vertices of a surface.
struct Columns {
  std::vector<Vec3> feet;
  std::vector<std::pair<std::size_t, std::size_t>> edges;  ///< of the surface, between these vertices
  Vec3 axis = Vec3::UnitZ();
  double length_mm = 0;
};

Columns columns_over(const BoneSurface& surface, const Vec3& axis, double voxel_mm) {
  Columns out{.feet = {}, .edges = {}, .axis = axis, .length_mm = 1.5 * surface.deepest_mm + 2 * voxel_mm};
  constexpr std::size_t kNone = -1;
  std::vector<std::size_t> slots(surface.vertices.size() / BoneSurface::kStride, kNone);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const float* vertex = surface.vertices.data() + i * BoneSurface::kStride;
    if (!counts_as_reamed(vertex)) continue;
    slots[i] = out.feet.size();
    out.feet.push_back(Eigen::Map<const Eigen::Vector3f>(vertex).cast<double>());
  }
  for (std::size_t i = 0; i < surface.indices.size(); ++i) {
    // Inner edges belong to two triangles that pass them in opposite directions.
    const std::size_t from = slots[surface.indices[i]], to = slots[surface.indices[i % 3 == 2 ? i - 2 : i + 1]];
    if (from != kNone && to != kNone && from < to) out.edges.emplace_back(from, to);
  }
  return out;
}

/// Averages neighbours that differ by less than a voxel: the steps of whole voxels go, the edges of the tool stay.
std::vector<double> smoothed(std::vector<double> heights_mm, const Columns& columns, double voxel_mm) {
  constexpr int kRounds = 6;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> sums = heights_mm;
    std::vector<int> counts(sums.size(), 1);
    for (const auto& [a, b] : columns.edges) {
      if (std::abs(heights_mm[a] - heights_mm[b]) > voxel_mm) continue;
      sums[a] += heights_mm[b];
      sums[b] += heights_mm[a];
      ++counts[a];
      ++counts[b];
    }
    for (std::size_t i = 0; i < sums.size(); ++i) heights_mm[i] = sums[i] / counts[i];
  }
  return heights_mm;
}

/// Bone in each column, mm.
std::vector<double> bone_in(const Columns& columns, const Voxmap& voxmap, const FillBricks& fill) {
  std::vector<double> out(columns.feet.size());
  const double step_mm = kStep_voxels * voxmap.grid.voxel_mm;
  parallel_items(out.size(), [&](std::size_t i) {
    for (double s = -voxmap.grid.voxel_mm; s < columns.length_mm; s += step_mm) {
      out[i] += step_mm * bone_at(voxmap, fill, columns.feet[i] + s * columns.axis);
    }
  });
  return out;
}

/// Heights over the final surface, where the columns hold `now_mm` of bone, and in the end `last_mm`.
std::vector<double> heights(std::vector<double> now_mm, const std::vector<double>& last_mm, const Columns& columns,
                            double voxel_mm) {
  for (std::size_t i = 0; i < now_mm.size(); ++i) now_mm[i] -= last_mm[i];
  return smoothed(std::move(now_mm), columns, voxel_mm);
}

}  // namespace

Json reaming_data(const RunData& run, const BoneSurface& after) {
  const std::vector<std::int64_t>& frames = run.inputs().frames;
  const Voxmap& voxmap = run.voxmap();
  const Columns columns = columns_over(after, run.target().bone_from_tool.linear().col(2), voxmap.grid.voxel_mm);
  if (frames.size() < 2 || columns.feet.empty()) return nullptr;
  const std::vector<double> last_mm = bone_in(columns, voxmap, run.last_fill());
  FillBricks fill = fill_at(run.inputs(), frames.front());
  Json times = Json::array();
  std::vector<std::vector<double>> states;
  std::size_t applied = 0;
  for (const std::size_t chosen : evenly_spaced(frames.size(), kMaxStates)) {
    while (applied < chosen) apply_snapshot(run.dir(), frames[++applied], fill);
    times.push_back(short_number(run.row_of(frames[chosen]).time_s));
    states.push_back(heights(bone_in(columns, voxmap, fill), last_mm, columns, voxmap.grid.voxel_mm));
  }
  double most_mm = 0;
  for (const auto& state : states) most_mm = std::max(most_mm, *std::ranges::max_element(state));
  std::vector<std::uint8_t> bytes;
  for (const auto& state : states) append_numbers16(state, 0, most_mm, bytes);
  return {{"time_s", std::move(times)},
          {"vertices", columns.feet.size()},
          {"most_mm", most_mm},
          {"bytes", compressed_base64(bytes)}};
}

}  // namespace reamsim
