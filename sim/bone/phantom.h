// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>

#include "sim/bone/bone.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

// Verification blocks have closed-form surfaces. Lattice planes lie at multiples of the voxel size, so that a top face
// at z = 0 lies between two layers of voxels. The glenoid frame is at the centre of the top face, +z up.

/// A block of uniform density below z = 0.
Bone half_space_phantom(const BoneSettings& settings);
/// The block with a spherical cup of `radius_mm`, `cup_depth_mm` deep, in the middle of its top face.
/// Throws InputError when the cup is deeper than the block or its own radius.
Bone cup_phantom(const BoneSettings& settings);
/// The block with `cortical_mm` of cortical density on trabecular density. Throws InputError when the layer is thicker
/// than the block.
Bone layered_phantom(const BoneSettings& settings);
/// A sphere about the origin; the glenoid frame is at its pole (0, 0, radius).
Bone sphere_phantom(const BoneSettings& settings);

/// The parametric glenoid (sim/bone/glenoid_shape.h): subchondral plate, cortical wall, and trabecular bone whose
/// density decreases with the distance from the plate, with seeded texture. The glenoid frame is at the centre of the
/// face, +z along its normal. Notes the orientation of the face in `report`. Throws InputError: no side, a face radius
/// or wear that does not fit the face.
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

}  // namespace reamsim
