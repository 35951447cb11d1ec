// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/glenoid_rim.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace reamsim {

namespace {

constexpr double kFall_mm = 4;  // of the surface, that ends the face
constexpr double kFarthest_mm = 35;
constexpr double kWallRise_mm = 3;   // a surface that rises more than this in a step is a wall
constexpr double kFallReach_mm = 8;  // one that falls more ends
constexpr double kLeastStep_mm = 0.4;
/// Distance from the origin, height.
using Profile = std::vector<Vec2>;

/// The profile of the surface in a direction, until it ends or has fallen; nullopt where it does neither.
std::optional<Profile> profile_of(const BoneProbe& probe, const Rigid& bone_from_face, double angle) {
  const Vec3 along(std::cos(angle), std::sin(angle), 0), down = -bone_from_face.linear().col(2);
  const double step_mm = std::max(kLeastStep_mm, probe.voxel_mm());
  Profile out{Vec2::Zero()};
  double highest_mm = 0;
  for (double at_mm = step_mm; at_mm <= kFarthest_mm; at_mm += step_mm) {
    const double start_mm = out.back().y() + kWallRise_mm;
    const Vec3 from = bone_from_face * Vec3(at_mm * along + start_mm * Vec3::UnitZ());
    if (probe.fraction(from) >= 0.5) return std::nullopt;
    const auto fall = probe.distance_to_bone(from, down, kWallRise_mm + kFallReach_mm);
    out.emplace_back(at_mm, fall ? start_mm - *fall : highest_mm - kFall_mm);
    highest_mm = std::max(highest_mm, out.back().y());
    if (!fall || out.back().y() <= highest_mm - kFall_mm) return out;
  }
  return std::nullopt;
}

/// Where the surface has turned to fall by 45 degrees: the point farthest outwards and upwards. On a rounded rim that
/// is about its middle; where a gentle slope begins beside the face a steeper edge would lie far down on it.
Vec2 corner_of(const Profile& profile) {
  return *std::ranges::max_element(profile, {}, [](const Vec2& p) { return p.sum(); });
}

}  // namespace

RimWalk walk_to_rim(const BoneProbe& probe, const Rigid& bone_from_face, int directions) {
  RimWalk out{.rim_mm = {}, .directions = directions};
  for (int k = 0; k < directions; ++k) {
    const double angle = 2 * std::numbers::pi * k / directions;
    const auto profile = profile_of(probe, bone_from_face, angle);
    if (!profile) continue;
    const Vec2 corner = corner_of(*profile);
    if (corner.x() > 0) out.rim_mm.emplace_back(corner.x() * std::cos(angle), corner.x() * std::sin(angle), corner.y());
  }
  return out;
}

}  // namespace reamsim
