#pragma once

#include <optional>

#include "sim/base/geometry.h"

namespace reamsim {

/// The exact test of two boxes by separating axes (Gottschalk's 15 axes), one box in the other's frame (paper §3.4).
/// `a` is axis-aligned in frame A, `b` in frame B; touching boxes overlap.
bool boxes_overlap(const Aabb& a, const Aabb& b, const Rigid& a_from_b);

/// The volume of interest: the axis-aligned box, in the tool's frame, that holds the bone's box, cut with the tool's
/// own box (paper §3.4, Fig. 5). It overestimates the intersection and never misses. nullopt when the boxes are apart.
std::optional<Aabb> volume_of_interest(const Aabb& tool, const Aabb& bone, const Rigid& tool_from_bone);

/// OBB against OBB, then the VOI; nullopt means that nothing can touch.
std::optional<Aabb> broad_phase(const Aabb& tool, const Aabb& bone, const Rigid& tool_from_bone);

}  // namespace reamsim
