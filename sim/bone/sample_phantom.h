#pragma once

#include <functional>

#include "sim/bone/voxmap.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Density in g/cm³ at a point of B in mm; kAir where there is no bone. Called from several threads at once.
using DensityField = std::function<double(const Vec3&)>;
inline constexpr double kAir = -1;

/// Whether the ball about a point of B with a radius in mm is certainly all air; false where that is not known.
using AirTest = std::function<bool(const Vec3&, double)>;

/// Density to grade at every voxel's centre, in the frame "phantom". Whole bricks are left out where `all_air` says so.
/// The result does not depend on the threads.
Voxmap sample_phantom(
    const VoxelGrid& grid, const DensitySettings& density, const DensityField& field,
    const AirTest& all_air = [](const Vec3&, double) { return false; });

/// The mapping that the scenario asks for.
DensityMapping mapping_from(const DensitySettings& density);

}  // namespace reamsim
