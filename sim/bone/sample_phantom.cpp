// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/sample_phantom.h"

#include <numbers>

#include "sim/bone/voxmap/sample_voxels.h"

namespace reamsim {

namespace {

bool sample_brick(const VoxelGrid& grid, const DensityField& field, const Vec3i& brick_coord, GradeBricks::Brick& out) {
  const Vec3i first = GradeBricks::kSide * brick_coord;
  const Vec3i last = (first + Vec3i::Constant(GradeBricks::kSide)).cwiseMin(grid.dims);
  bool any = false;
  for_each_voxel(first, last - Vec3i::Ones(), [&](const Vec3i& voxel) {
    const double density = field(grid.center_mm(voxel));
    if (density < 0) return;
    out[static_cast<std::size_t>(BrickLattice::offset_of(voxel))] = DensityMapping::grade_from_density(density);
    any = true;
  });
  return any;
}

}  // namespace

DensityMapping mapping_from(const DensitySettings& density) {
  return {density.ash_slope_g_cm3_per_hu, density.ash_offset_g_cm3, density.ash_fraction};
}

FilledVoxmap sample_phantom(const VoxelGrid& grid, const DensitySettings& density, const DensityField& field,
                            const PartialField& partial, const AirTest& all_air) {
  FilledVoxmap voxmap(grid);
  voxmap.mapping = mapping_from(density);
  voxmap.frame = "phantom";
  const double radius_mm = 0.5 * GradeBricks::kSide * grid.voxel_mm * std::numbers::sqrt3;
  voxmap.grade = sample_bricks(grid.dims, [&](const Vec3i& coord, GradeBricks::Brick& brick) {
    const Vec3 center_mm =
        grid.origin_mm + GradeBricks::kSide * grid.voxel_mm * (coord.cast<double>() + Vec3::Constant(0.5));
    return !all_air(center_mm, radius_mm) && sample_brick(grid, field, coord, brick);
  });
  if (!partial) return voxmap;
  const auto sample = [&](const Vec3i& voxel, std::uint8_t grade) -> SurfaceVoxel {
    const PartialVoxel found = partial(grid.center_mm(voxel));
    return {found.fraction, grade != 0 ? grade : DensityMapping::grade_from_density(found.density_g_cm3)};
  };
  set_partial_fill(sample, voxmap);
  return voxmap;
}

}  // namespace reamsim
