// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Density in g/cm³ at a point of B in mm; kAir without bone. Called from several threads at once.
using DensityField = std::function<double(const Vec3&)>;
inline constexpr double kAir = -1;

/// Whether a ball around a point of B with a radius in mm certainly contains no bone.
using AirTest = std::function<bool(const Vec3&, double)>;

struct PartialVoxel {
  double fraction = 0;  ///< of bone, 0…1
  double density_g_cm3 = 0;
};
/// Describes the voxel around a point of B, mm. Called for voxels at the surface only, from several threads at once.
using PartialField = std::function<PartialVoxel(const Vec3& center_mm)>;

/// Samples the density at the centres of the voxels, in the frame "phantom", except in bricks for which `all_air` is
/// true. Without `partial` the voxels at the surface are whole. The result does not depend on the threads.
FilledVoxmap sample_phantom(
    const VoxelGrid& grid, const DensitySettings& density, const DensityField& field, const PartialField& partial = {},
    const AirTest& all_air = [](const Vec3&, double) { return false; });

DensityMapping mapping_from(const DensitySettings& density);

}  // namespace reamsim
