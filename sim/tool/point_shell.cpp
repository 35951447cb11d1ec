// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/point_shell.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "sim/base/error.h"
#include "sim/tool/distance_grid.h"

namespace reamsim {

namespace {

/// A triangle in units of cells from the grid's corner.
using GridTriangle = std::array<Vec3, 3>;

/// The first and the last cell of 0…resolution−1 that the closed interval [low, high] touches.
std::pair<int, int> cells_touched(double low, double high, int resolution) {
  const double top = resolution - 1;
  return {static_cast<int>(std::clamp(std::ceil(low) - 1, 0.0, top)),
          static_cast<int>(std::clamp(std::floor(high), 0.0, top))};
}

/// The v coordinates of the triangle where its u lies in [low, high]; empty (first > second) where there are none.
std::pair<double, double> extent_in_slab(const GridTriangle& t, int u, int v, double low, double high) {
  std::pair<double, double> extent{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 &p = t[k], &q = t[(k + 1) % 3];
    const double along = q[u] - p[u];
    if (std::max(p[u], q[u]) < low || std::min(p[u], q[u]) > high) continue;
    double first = 0, last = 1;
    if (along != 0) {
      first = std::clamp((low - p[u]) / along, 0.0, 1.0);
      last = std::clamp((high - p[u]) / along, 0.0, 1.0);
    }
    const double v_first = p[v] + first * (q[v] - p[v]), v_last = p[v] + last * (q[v] - p[v]);
    extent.first = std::min({extent.first, v_first, v_last});
    extent.second = std::max({extent.second, v_first, v_last});
  }
  return extent;
}

/// Appends the codes of the cells that `t` touches, column by column along the axis of its normal's largest component:
/// the plane crosses two or three cells per column, whatever the size of the triangle.
void add_cells(const GridTriangle& t, int resolution, std::vector<std::uint64_t>& codes) {
  const auto& [a, b, c] = t;
  const Vec3 normal = (b - a).cross(c - a);
  int w = 0;
  const double steepest = normal.cwiseAbs().maxCoeff(&w);
  if (!(steepest > 0)) return;  // no area: the neighbours in a closed mesh have its edges
  const int u = (w + 1) % 3, v = (w + 2) % 3;
  const Vec3 low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  const auto [u_first, u_last] = cells_touched(low[u], high[u], resolution);
  // Extends ranges for rounding; the exact test decides.
  constexpr double kSlack = 1e-6;
  const double spread = 0.5 * (std::abs(normal[u]) + std::abs(normal[v])) / steepest + kSlack;
  Vec3i cell;
  for (cell[u] = u_first; cell[u] <= u_last; ++cell[u]) {
    const auto [v_low, v_high] = extent_in_slab(t, u, v, cell[u] - kSlack, cell[u] + 1 + kSlack);
    if (v_low > v_high) continue;
    const auto [v_first, v_last] = cells_touched(v_low - kSlack, v_high + kSlack, resolution);
    for (cell[v] = v_first; cell[v] <= v_last; ++cell[v]) {
      const double du = cell[u] + 0.5 - a[u], dv = cell[v] + 0.5 - a[v];
      const double plane = a[w] - (normal[u] * du + normal[v] * dv) / normal[w];
      const double bottom = std::max(low[w], plane - spread), top = std::min(high[w], plane + spread);
      if (bottom > top) continue;
      const auto [w_first, w_last] = cells_touched(bottom, top, resolution);
      for (cell[w] = w_first; cell[w] <= w_last; ++cell[w])
        if (triangle_touches_box(a, b, c, cell.cast<double>().array() + 0.5, Vec3::Constant(0.5)))
          codes.push_back(morton_encode(cell.x(), cell.y(), cell.z()));
    }
  }
}

/// Sorts codes, and removes duplicates: neighbouring triangles touch the same cells.
void make_unique(std::vector<std::uint64_t>& codes) {
  std::ranges::sort(codes);
  codes.erase(std::ranges::unique(codes).begin(), codes.end());
}

}  // namespace

PointShell shell_grid(const Aabb& box, int resolution) {
  if (resolution < 1 || resolution > kMaxShellResolution)
    throw InputError("shell resolution " + std::to_string(resolution) + " is outside 1 to " +
                     std::to_string(kMaxShellResolution));
  if (box.empty() || !((box.max - box.min).maxCoeff() > 0)) throw InputError("the mesh has no extent");
  PointShell shell;
  shell.resolution = resolution;
  shell.cell_mm = (box.max - box.min).maxCoeff() / std::max(1, resolution - 1);
  shell.origin_mm = box.center() - Vec3::Constant(0.5 * resolution * shell.cell_mm);
  // The lowest point lies at cell centres, so that a tool's cutting end is sampled without an offset.
  if (resolution > 1) shell.origin_mm.z() = box.min.z() - 0.5 * shell.cell_mm;
  return shell;
}

PointShell voxelize_surface(const TriangleMesh& mesh, int resolution) {
  PointShell shell = shell_grid(mesh.bounds(), resolution);
  std::size_t enough = std::size_t{1} << 20;  // codes, so that duplicates take little memory
  for (const auto& triangle : mesh.triangles) {
    GridTriangle corners = mesh.corners(triangle);
    for (Vec3& corner : corners) corner = (corner - shell.origin_mm) / shell.cell_mm;
    add_cells(corners, resolution, shell.codes);
    if (shell.codes.size() < enough) continue;
    make_unique(shell.codes);
    enough = std::max(enough, 2 * shell.codes.size());
  }
  make_unique(shell.codes);
  shell.codes.shrink_to_fit();
  return shell;
}

double expected_leak(double spacing_voxels) {
  struct Measured {
    double spacing_voxels;
    double leak;
  };
  // Means over random orientations and offsets of the cube: 4·10⁶ up to 0.8, 4·10⁵ above.
  constexpr Measured kMeasured[] = {{kHardlyLeakingSpacing, 1e-6},
                                    {0.75, 4.7e-5},
                                    {0.8, 8.0e-4},
                                    {0.85, 3.8e-3},
                                    {0.9, 1.05e-2},
                                    {1.0, 4.2e-2},
                                    {1.2, 0.196},
                                    {1.5, 0.466},
                                    {2.0, 0.700},
                                    {kLargestMeasuredSpacing, 0.866}};
  if (spacing_voxels <= 0.5) return 0;
  if (spacing_voxels <= kMeasured[0].spacing_voxels) return kMeasured[0].leak;
  for (std::size_t i = 1; i < std::size(kMeasured); ++i) {
    const Measured &a = kMeasured[i - 1], &b = kMeasured[i];
    if (spacing_voxels > b.spacing_voxels) continue;
    const double t = (spacing_voxels - a.spacing_voxels) / (b.spacing_voxels - a.spacing_voxels);
    return a.leak * std::pow(b.leak / a.leak, t);
  }
  return kMeasured[std::size(kMeasured) - 1].leak;
}

}  // namespace reamsim
