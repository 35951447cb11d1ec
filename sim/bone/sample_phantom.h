#pragma once

#include <functional>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Density in g/cm³ at a point of B in mm; kAir where there is no bone. Called from several threads at once.
using DensityField = std::function<double(const Vec3&)>;
inline constexpr double kAir = -1;

/// Whether the ball about a point of B with a radius in mm is certainly all air; false where that is not known.
using AirTest = std::function<bool(const Vec3&, double)>;

/// Part of the voxel about a point of B (mm) that is bone, 0…1, and the density of that bone, g/cm³. Called for voxels
/// at the surface only, from several threads at once.
struct PartialVoxel {
  double fraction = 0;
  double density_g_cm3 = 0;
};
using PartialField = std::function<PartialVoxel(const Vec3& center_mm)>;

/// Density to grade at every voxel's centre, in the frame "phantom". Whole bricks are left out where `all_air` says so.
/// Voxels at the surface are whole without `partial`. The result does not depend on the threads.
FilledVoxmap sample_phantom(
    const VoxelGrid& grid, const DensitySettings& density, const DensityField& field, const PartialField& partial = {},
    const AirTest& all_air = [](const Vec3&, double) { return false; });

/// The mapping that the scenario asks for.
DensityMapping mapping_from(const DensitySettings& density);

}  // namespace reamsim
