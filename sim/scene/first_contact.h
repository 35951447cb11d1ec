// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>

#include "sim/bone/bone.h"
#include "sim/tool/motion.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// Where a tool that comes along a line from outside first touches the bone.
struct FirstContact {
  double travel_mm = 0;           ///< of the tool's origin along the line, from the given point
  Vec3 origin_mm = Vec3::Zero();  ///< the tool's origin there, B
  Vec3 bone_mm = Vec3::Zero();    ///< the point of the bone that is touched, B
};

/// First contact of an envelope with the axis `-direction` (unit vector, B) whose origin moves along `direction` on the
/// line through `through_mm` (B), from outside the bounding box of the bone. The bone is that of first_bone_mm(): whole
/// voxels are cubes, others are cut by the plane of their fill. nullopt where the envelope meets none. Error: well
/// below 0.1 voxel of that surface.
std::optional<FirstContact> find_first_contact(const BoneView& bone, const Profile& envelope, const Vec3& through_mm,
                                               const Vec3& direction);

/// First contact of a plunge, of which only entry_mm and axis count; `bone` is as it is before any reaming. Throws
/// InputError at entry_mm of `section` where the tool meets no bone.
FirstContact find_first_contact(const Bone& bone, const Tool& tool, const PlungeSettings& plunge, PoseFrame frame,
                                const std::string& section = "motion.plunge");

/// For users, one line.
std::string sentence_of(const FirstContact& contact);

/// The same plunge with the depth counted from entry_mm, which is moved to the first contact.
PlungeSettings counted_from(const FirstContact& contact, PlungeSettings plunge);

}  // namespace reamsim
