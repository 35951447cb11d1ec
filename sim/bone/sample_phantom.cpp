#include "sim/bone/sample_phantom.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <numbers>

namespace reamsim {

namespace {

constexpr int kSide = FillBricks::kSide;

void sample_brick(Voxmap& voxmap, const Vec3i& first, const DensityField& field) {
  const VoxelGrid& grid = voxmap.grid;
  const Vec3i last = (first + Vec3i::Constant(kSide)).cwiseMin(grid.dims);
  for (int z = first.z(); z < last.z(); ++z) {
    for (int y = first.y(); y < last.y(); ++y) {
      for (int x = first.x(); x < last.x(); ++x) {
        const double density = field(grid.center_mm(x, y, z));
        if (density < 0) continue;
        voxmap.grade[static_cast<std::size_t>(grid.index(x, y, z))] = DensityMapping::grade_from_density(density);
      }
    }
  }
}

}  // namespace

DensityMapping mapping_from(const DensitySettings& density) {
  return {density.ash_slope_g_cm3_per_hu, density.ash_offset_g_cm3, density.ash_fraction};
}

Voxmap sample_phantom(const VoxelGrid& grid, const DensitySettings& density, const DensityField& field,
                      const AirTest& all_air) {
  Voxmap voxmap(grid);
  voxmap.mapping = mapping_from(density);
  voxmap.frame = "phantom";
  const Vec3i bricks = voxmap.fill.brick_dims();
  const double radius_mm = 0.5 * kSide * grid.voxel_mm * std::numbers::sqrt3;
  tbb::parallel_for(tbb::blocked_range<int>(0, bricks.z()), [&](const tbb::blocked_range<int>& layers) {
    for (int z = layers.begin(); z < layers.end(); ++z) {
      for (int y = 0; y < bricks.y(); ++y) {
        for (int x = 0; x < bricks.x(); ++x) {
          const Vec3 center_mm = grid.origin_mm + kSide * grid.voxel_mm * (Vec3(x, y, z) + Vec3::Constant(0.5));
          if (!all_air(center_mm, radius_mm)) sample_brick(voxmap, kSide * Vec3i(x, y, z), field);
        }
      }
    }
  });
  return voxmap;
}

}  // namespace reamsim
