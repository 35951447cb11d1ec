// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "kernels/shared.h"
#include "sim/base/geometry.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// Exact overlap test of two boxes by separating axes (Gottschalk's 15 axes), in the frame of one box (paper §3.4).
/// `a` is axis-aligned in frame A, `b` in frame B. Touching boxes overlap.
bool boxes_overlap(const Aabb& a, const Aabb& b, const Rigid& a_from_b);

/// The volume of interest: the intersection of the tool's box with the axis-aligned bounding box, in the tool's frame,
/// of the bone's box (paper §3.4, Fig. 5). Conservative. nullopt when it is empty.
std::optional<Aabb> volume_of_interest(const Aabb& tool, const Aabb& bone, const Rigid& tool_from_bone);

/// OBB against OBB, then the VOI; nullopt where nothing can touch.
std::optional<Aabb> broad_phase(const Aabb& tool, const Aabb& bone, const Rigid& tool_from_bone);

/// The volume of interest in voxmap coordinates (paper §4.3.2): the voxels of `bone` whose centres can lie in
/// `tool_box` (T, mm) in the substep's pose. Conservative.
VoxelBox voxel_voi(const SubstepArgs& args, const Aabb& tool_box, const VoxelBox& bone);

}  // namespace reamsim
