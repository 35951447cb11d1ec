// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// The surface of the bone in a partly filled voxel: the plane across the gradient of the fill that leaves the voxel's
/// fill on its inner side (Parker and Youngs 1992, AWE preprint 01/92). Bone is where normal·(p − centre) ≤ offset_mm.
struct VoxelPlane {
  Vec3 normal;  ///< unit vector out of the bone
  double offset_mm = 0;
};

/// The remaining fraction of a voxel, 0…1; 0 in air and outside the lattice.
double bone_fraction(const BoneView& bone, const Vec3i& voxel);

/// nullopt for a whole voxel, which is a cube of bone. `fallback`: unit normal where the fill has no gradient.
std::optional<VoxelPlane> voxel_plane(const BoneView& bone, const Vec3i& voxel, const Vec3& fallback);

}  // namespace reamsim
