// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>

#include "sim/bone/bone.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The parametric glenoid (sim/bone/glenoid_shape.h): subchondral plate, cortical wall, and trabecular bone whose
/// density decreases with the distance from the plate, with seeded texture. The glenoid frame is at the centre of the
/// face, +z along its normal. Notes the orientation of the face in `report`. Throws InputError: a width, face
/// radius or wear that does not fit the face.
Bone glenoid_phantom(const BoneSettings& settings, Diagnostics& report);
/// The same bone on a given lattice, clipped by it. Throws as above.
FilledVoxmap sample_glenoid(const BoneSettings& settings, const VoxelGrid& grid);

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

/// Throws the InputError of a length in bone.phantom.
[[noreturn]] void fail_phantom(const std::string& key, double found_mm, const std::string& expected);

}  // namespace reamsim
