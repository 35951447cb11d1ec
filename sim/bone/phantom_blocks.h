#pragma once

#include "sim/bone/bone.h"

namespace reamsim {

// Bones with closed forms, for verification. Lattice planes lie at multiples of the voxel size, so that a top face at
// z = 0 falls between two layers of voxels. The glenoid frame stands at the centre of the top face, +z up.

/// A block of uniform density below z = 0.
Bone half_space_phantom(const BoneSettings& settings);
/// The block with a spherical cup of `radius_mm`, `cup_depth_mm` deep, in the middle of its top face.
/// Throws InputError when the cup is deeper than the block or its own radius.
Bone cup_phantom(const BoneSettings& settings);
/// The block with `cortical_mm` of cortical density on trabecular density. Throws InputError when the layer is thicker
/// than the block.
Bone layered_phantom(const BoneSettings& settings);
/// A sphere about the origin; the glenoid frame stands on its pole (0, 0, radius).
Bone sphere_phantom(const BoneSettings& settings);

}  // namespace reamsim
