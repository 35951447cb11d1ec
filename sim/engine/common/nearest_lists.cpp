#include "sim/engine/common/nearest_lists.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "kernels/bricks.h"

namespace reamsim {

// Host and device lay the structs out alike.
static_assert(sizeof(EdgeList) == 8);
static_assert(sizeof(ProfileGrid) == 16);

namespace {

/// Half the diagonal between the corner voxels' centres of a brick, in voxels, and as far as it moves within a window
/// of substeps.
const double kBrickReach = 0.5 * (RS_BRICK_SIDE - 1) * std::sqrt(3.0) + kWindowShiftVoxels;
constexpr double kGridVoxels = 4;
/// Touched voxels lie within a few voxels of the surface; teeth, resolved, may lie deeper, and use the full list.
constexpr double kBandVoxels = 8;
constexpr int kMostCells = 1 << 16;
/// Parts along each side into which a cell's surroundings are cut to find what can be nearest.
constexpr int kParts = 8;
/// Room for the rounding of single precision in the kernels, mm.
constexpr double kSlack_mm = 1e-3;

/// Lays the grid over the profile and a band round it; cells grow where there would be too many.
ProfileGrid lay_grid(const Profile& profile, double voxel_mm) {
  const Aabb box = profile.bounds();
  const double margin = kBandVoxels * voxel_mm;
  const double width = box.max.x() + margin, height = box.max.z() - box.min.z() + 2 * margin;
  const double cell_mm = std::max(kGridVoxels * voxel_mm, std::sqrt(width * height / kMostCells));
  return {static_cast<float>(box.min.z() - margin), static_cast<float>(1 / cell_mm),
          static_cast<rs_i32>(std::ceil(width / cell_mm)), static_cast<rs_i32>(std::ceil(height / cell_mm))};
}

using Distance = std::function<double(std::size_t, const Vec2&)>;

/// Of `among`, those that can be nearest to a point within `reach_mm` of `center`: distances change by no more than the
/// way that the point moves.
std::vector<rs_u16> nearest_within(const Distance& distance, const std::vector<rs_u16>& among, const Vec2& center,
                                   double reach_mm) {
  std::vector<double> distances;
  for (const rs_u16 i : among) distances.push_back(distance(i, center));
  const double limit = *std::min_element(distances.begin(), distances.end()) + 2 * reach_mm + kSlack_mm;
  std::vector<rs_u16> out;
  for (std::size_t i = 0; i < among.size(); ++i) {
    if (distances[i] <= limit) out.push_back(among[i]);
  }
  return out;
}

/// The same, tighter: for each part of the square round `center`, and all together.
std::vector<rs_u16> nearest_by_parts(const Distance& distance, const std::vector<rs_u16>& among, const Vec2& center,
                                     double reach_mm) {
  const std::vector<rs_u16> coarse = nearest_within(distance, among, center, reach_mm);
  const double part = 2 * reach_mm / kParts;
  std::vector<rs_u16> out;
  for (int i = 0; i < kParts * kParts && out.size() < coarse.size(); ++i) {
    const Vec2 at = center + part * Vec2(i % kParts + 0.5, i / kParts + 0.5) - Vec2::Constant(reach_mm);
    for (const rs_u16 edge : nearest_within(distance, coarse, at, std::sqrt(0.5) * part)) out.push_back(edge);
    std::sort(out.begin(), out.end());
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
  out.grid = lay_grid(profile, voxel_mm);
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
