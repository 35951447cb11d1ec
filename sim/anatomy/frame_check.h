// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/base/error.h"
#include "sim/bone/bone.h"

namespace reamsim {

/// Whether there is air on any of the six sides of a voxel, as outside the lattice.
bool has_air_beside(const Voxmap& voxmap, const Vec3i& voxel);

/// Bone in a sphere around a point, on both sides of a plane through it.
struct NearbyBone {
  double radius_mm = 0;
  double ahead_mm3 = 0;  ///< on the side of the plane's normal
  double behind_mm3 = 0;
  Vec3 outward = Vec3::Zero();  ///< unit vector from the centroid of the bone to the point; 0 where they coincide
};
NearbyBone nearby_bone(const Voxmap& voxmap, const Vec3& point_mm, const Vec3& normal, double radius_mm);

/// Compares the glenoid frame of a bone with the unreamed bone. Mistakes: a centre more than 10 mm from the surface, a
/// normal that points into the bone. Warnings, because a specimen may be scanned in any position: in LPS a left glenoid
/// does not face +x, or superior is not +z. `settings` determine the keys in the messages. Does nothing without a frame
/// or for the frame of a phantom.
void check_glenoid_frame(const Bone& bone, const BoneSettings& settings, MistakeList& mistakes, Diagnostics& report);

}  // namespace reamsim
