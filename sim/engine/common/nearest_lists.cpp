// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/nearest_lists.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "kernels/bricks.h"

namespace reamsim {

// The structs have the same layout on host and device.
static_assert(sizeof(PieceList) == 8);
static_assert(sizeof(OutlineGrid) == 16);

namespace {

/// Half the diagonal between the centres of a brick's corner voxels plus the motion within a window, voxels.
const double kBrickReach = 0.5 * (RS_BRICK_SIDE - 1) * std::sqrt(3.0) + kWindowShiftVoxels;
constexpr double kGridVoxels = 4;
/// Width of the band around the profile with lists of its own, voxels: touched voxels lie within a few voxels of the
/// surface. Resolved cutting edges may lie deeper, where the full list is used.
constexpr double kBandVoxels = 8;
constexpr int kMaxCells = 1 << 16;
/// Subdivisions of a cell's surroundings along each side in the search for the nearest parts.
constexpr int kParts = 8;
/// Allowance for the single precision of the kernels, mm.
constexpr double kSlack_mm = 1e-3;

/// The grid over the profile and its band. Its cells grow where there would be more than kMaxCells.
OutlineGrid make_grid(const Profile& profile, double voxel_mm) {
  const Aabb box = profile.bounds();
  const double margin = kBandVoxels * voxel_mm;
  const double width = box.max.x() + margin, height = box.max.z() - box.min.z() + 2 * margin;
  const double cell_mm = std::max(kGridVoxels * voxel_mm, std::sqrt(width * height / kMaxCells));
  return {static_cast<float>(box.min.z() - margin), static_cast<float>(1 / cell_mm),
          static_cast<rs_i32>(std::ceil(width / cell_mm)), static_cast<rs_i32>(std::ceil(height / cell_mm))};
}

using Distance = std::function<double(std::size_t, const Vec2&)>;

/// The elements of `among` that can be nearest to a point within `reach_mm` of `center`, because a distance changes by
/// at most the motion of the point.
std::vector<rs_u16> nearest_within(const Distance& distance, const std::vector<rs_u16>& among, const Vec2& center,
                                   double reach_mm) {
  std::vector<double> distances;
  for (const rs_u16 i : among) distances.push_back(distance(i, center));
  const double limit = std::ranges::min(distances) + 2 * reach_mm + kSlack_mm;
  std::vector<rs_u16> out;
  for (std::size_t i = 0; i < among.size(); ++i) {
    if (distances[i] <= limit) out.push_back(among[i]);
  }
  return out;
}

/// The same with a tighter bound: the union over the parts of the square around `center`.
std::vector<rs_u16> nearest_by_parts(const Distance& distance, const std::vector<rs_u16>& among, const Vec2& center,
                                     double reach_mm) {
  const std::vector<rs_u16> coarse = nearest_within(distance, among, center, reach_mm);
  const double part = 2 * reach_mm / kParts;
  std::vector<rs_u16> out;
  for (int i = 0; i < kParts * kParts && out.size() < coarse.size(); ++i) {
    const int column = i % kParts, row = i / kParts;
    const Vec2 at = center + part * Vec2(column + 0.5, row + 0.5) - Vec2::Constant(reach_mm);
    for (const rs_u16 edge : nearest_within(distance, coarse, at, std::sqrt(0.5) * part)) out.push_back(edge);
    std::ranges::sort(out);
    out.erase(std::unique(out.begin(), out.end()), out.end());
  }
  return out;
}

}  // namespace

NearestLists make_nearest_lists(const Profile& profile, std::size_t count, const Distance& distance, double voxel_mm) {
  NearestLists out;
  out.numbers.resize(count);
  std::iota(out.numbers.begin(), out.numbers.end(), rs_u16{0});
  const std::vector<rs_u16> all = out.numbers;
  out.lists.push_back({0, static_cast<rs_u32>(count)});
  out.grid = make_grid(profile, voxel_mm);
  const double cell_mm = 1 / double{out.grid.per_mm};
  const double reach_mm = kBrickReach * voxel_mm + std::sqrt(0.5) * cell_mm + kSlack_mm;
  for (int z = 0; z < out.grid.count_z; ++z) {
    for (int r = 0; r < out.grid.count_r; ++r) {
      const Vec2 center((r + 0.5) * cell_mm, double{out.grid.z0} + (z + 0.5) * cell_mm);
      double nearest = std::numeric_limits<double>::infinity();
      for (const rs_u16 part : all) nearest = std::min(nearest, distance(part, center));
      if (nearest > kBandVoxels * voxel_mm + reach_mm) {
        out.lists.push_back(out.lists.front());
        continue;
      }
      const std::vector<rs_u16> list = nearest_by_parts(distance, all, center, reach_mm);
      out.lists.push_back({static_cast<rs_u32>(out.numbers.size()), static_cast<rs_u32>(list.size())});
      out.numbers.insert(out.numbers.end(), list.begin(), list.end());
    }
  }
  return out;
}

}  // namespace reamsim
