// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/find_glenoid.h"

#include <fmt/core.h>
#include <algorithm>
#include <limits>
#include <numbers>
#include <utility>

namespace reamsim {

namespace {

/// Largest distance of the glenoid centre from the bone. A joint gap has some mm; a worn face is bone itself.
constexpr double kFarthestCenter_mm = 10;
/// The normal is compared with the bone up to this far beyond the nearest surface.
constexpr double kBeyondSurface_mm = 8;
/// The normal points inwards if the bone ahead exceeds that behind by this factor. In a half space the ratio is 1 for a
/// normal along its face, 0 for one perpendicular to it.
constexpr double kInward = 1.5;
/// Largest angle between the normal and the direction out of the bone without a warning. Wear tilts faces much less.
constexpr double kOblique_deg = 50;
/// A centroid nearer to the centre of the sphere is not significant, in radii.
constexpr double kMinCentroid = 0.05;
constexpr double kMinComponent = 0.1;  // a smaller component of a direction is not significant (about 6°)

/// The stored bricks and lower bounds of their distance from a point, the nearest first.
std::vector<std::pair<double, Vec3i>> bricks_by_distance(const Voxmap& voxmap, const Vec3& point_mm) {
  const double side_mm = BrickLattice::kSide * voxmap.grid.voxel_mm;
  std::vector<std::pair<double, Vec3i>> out;
  for (const Vec3i& coord : voxmap.grade.stored_coords()) {
    const Vec3 low = voxmap.grid.origin_mm + side_mm * coord.cast<double>();
    const Vec3 nearest = point_mm.cwiseMax(low).cwiseMin(low + Vec3::Constant(side_mm));
    out.emplace_back((nearest - point_mm).norm(), coord);
  }
  std::ranges::stable_sort(out, {}, [](const auto& entry) { return entry.first; });
  return out;
}

struct FrameKeys {
  std::string center, normal, superior;
};

FrameKeys keys_of(const BoneSettings& settings) {
  const std::string at = "bone.glenoid.";
  if (settings.glenoid.near_mm) return {at + "near_mm", at + "near_mm", at + "superior"};
  if (settings.glenoid.landmarks) {
    return {at + "landmarks.glenoid_center_mm", at + "landmarks.trigonum_spinae_mm",
            at + "landmarks.inferior_angle_mm"};
  }
  if (settings.glenoid.center_mm) return {at + "center_mm", at + "normal", at + "superior"};
  return {"bone.vdb.path", "bone.vdb.path", "bone.vdb.path"};
}

/// The point of the unreamed bone's surface nearest to a given point.
struct NearestSurface {
  Vec3 point_mm = Vec3::Zero();  ///< B
  double distance_mm = 0;        ///< to within a voxel
  bool inside = false;           ///< the given point lies in the bone
};

/// nullopt without bone.
std::optional<NearestSurface> nearest_surface(const BoneView& bone, const Vec3& point_mm) {
  const Voxmap& voxmap = bone.voxmap;
  NearestSurface out{.point_mm = {}, .distance_mm = std::numeric_limits<double>::infinity(), .inside = false};
  for (const auto& [bound_mm, coord] : bricks_by_distance(voxmap, point_mm)) {
    if (bound_mm > out.distance_mm) break;
    for_each_bone_voxel_in(bone, coord, [&](const Vec3i& voxel, std::uint8_t, std::uint16_t) {
      const Vec3 center = voxmap.grid.center_mm(voxel);
      const double distance_mm = (center - point_mm).norm();
      if (distance_mm >= out.distance_mm || !has_air_beside(voxmap, voxel)) return;
      out.distance_mm = distance_mm;
      out.point_mm = center;
    });
  }
  if (!std::isfinite(out.distance_mm)) return std::nullopt;
  out.inside = voxmap.is_bone(voxmap.grid.voxel_of(point_mm));
  return out;
}

void check_center(const NearestSurface& nearest, const Vec3& center_mm, const FrameKeys& keys) {
  if (nearest.distance_mm <= kFarthestCenter_mm) return;
  throw InputError({}, keys.center,
                   fmt::format("found {}, {:.1f} mm {} the surface of the bone", point_text(center_mm),
                               nearest.distance_mm, nearest.inside ? "inside" : "outside"),
                   fmt::format("expected the centre of the glenoid face, within {:g} mm of the bone; the nearest point "
                               "of the surface is {}",
                               kFarthestCenter_mm, point_text(nearest.point_mm)));
}

void check_normal(const NearbyBone& bone, const Vec3& normal, const FrameKeys& keys, Diagnostics& report) {
  const double angle_deg = std::acos(std::clamp(normal.dot(bone.outward), -1.0, 1.0)) * 180 / std::numbers::pi;
  if (bone.outward == Vec3::Zero() || angle_deg <= kOblique_deg) return;
  const std::string found = fmt::format(
      "{:.0f} mm3 of bone within {:.1f} mm of the glenoid centre lie ahead of the normal and {:.0f} mm3 behind it",
      bone.ahead_mm3, bone.radius_mm, bone.behind_mm3);
  if (bone.ahead_mm3 > kInward * bone.behind_mm3) {
    const bool landmarks = keys.normal.ends_with("trigonum_spinae_mm");
    throw InputError({}, keys.normal, "the glenoid's normal points into the bone: " + found,
                     landmarks ? "place the trigonum spinae medial to the glenoid centre"
                               : fmt::format("give the direction out of the bone: [{:.3f}, {:.3f}, {:.3f}]",
                                             -normal.x(), -normal.y(), -normal.z()));
  }
  report.warn(
      fmt::format("the glenoid's normal is about {:.0f} degrees away from the direction out of the bone ({}): {}",
                  angle_deg, keys.normal, found));
}

void check_anatomy(const Bone& bone, const FrameKeys& keys, Diagnostics& report) {
  const Mat3 axes = bone.glenoid->bone_from_glenoid.linear();
  const double left = axes(0, 2), up = axes(2, 1);
  const std::string specimen = "; this may be meant only where the scan is not of a patient in the standard position";
  const bool contradicts =
      (bone.side == BodySide::left && left < -kMinComponent) || (bone.side == BodySide::right && left > kMinComponent);
  if (contradicts) {
    report.warn("bone.side is " + name_of(bone.side) + ", but the glenoid's normal points to the patient's " +
                (left > 0 ? "left" : "right") + fmt::format(" (x = {:.2f} in LPS)", left) + ", as on a " +
                (left > 0 ? "left" : "right") + " shoulder; check bone.side and " + keys.normal + specimen);
  }
  if (up < -kMinComponent) {
    report.warn("the glenoid's superior direction points down" + fmt::format(" (z = {:.2f} in LPS)", up) + "; check " +
                keys.superior + specimen);
  }
}

}  // namespace

bool has_air_beside(const Voxmap& voxmap, const Vec3i& voxel) {
  return std::ranges::any_of(kFaceSteps, [&](const Vec3i& step) { return !voxmap.is_bone(voxel + step); });
}

NearbyBone nearby_bone(const Voxmap& voxmap, const Vec3& point_mm, const Vec3& normal, double radius_mm) {
  constexpr int kSamples = 30;  // along the radius, at most
  const double step_mm = std::max(voxmap.grid.voxel_mm, radius_mm / kSamples);
  const int reach = static_cast<int>(radius_mm / step_mm);
  NearbyBone out{.radius_mm = radius_mm};
  Vec3 sum = Vec3::Zero();
  std::int64_t ahead = 0, behind = 0;
  for_each_voxel(Vec3i::Constant(-reach), Vec3i::Constant(reach), [&](const Vec3i& sample) {
    const Vec3 offset = step_mm * sample.cast<double>();
    if (offset.norm() > radius_mm || !voxmap.is_bone(voxmap.grid.voxel_of(point_mm + offset))) return;
    (offset.dot(normal) > 0 ? ahead : behind) += 1;
    sum += offset;
  });
  const double sample_mm3 = step_mm * step_mm * step_mm;
  out.ahead_mm3 = static_cast<double>(ahead) * sample_mm3;
  out.behind_mm3 = static_cast<double>(behind) * sample_mm3;
  const double centroid_mm = sum.norm() / std::max(1.0, static_cast<double>(ahead + behind));
  if (centroid_mm > kMinCentroid * radius_mm) out.outward = -sum.normalized();
  return out;
}

void check_glenoid_frame(const Bone& bone, const BoneSettings& settings, MistakeList& mistakes, Diagnostics& report) {
  if (!bone.glenoid || (bone.voxmap->frame == "phantom" && !settings.glenoid.is_given())) return;
  const FrameKeys keys = keys_of(settings);
  const Rigid& frame = bone.glenoid->bone_from_glenoid;
  const Vec3 center_mm = frame.translation(), normal = frame.linear().col(2);
  if (const auto nearest = nearest_surface(bone, center_mm)) {
    const bool near = mistakes.attempt([&] { check_center(*nearest, center_mm, keys); });
    if (near) {
      const NearbyBone round = nearby_bone(*bone.voxmap, center_mm, normal, nearest->distance_mm + kBeyondSurface_mm);
      mistakes.attempt([&] { check_normal(round, normal, keys, report); });
    }
  }
  // A mesh, a phantom and a VDB of another program have their own axes.
  const bool scanned = settings.source == BoneSource::ct || settings.source == BoneSource::vdb;
  if (scanned && bone.voxmap->frame == "LPS") check_anatomy(bone, keys, report);
}

}  // namespace reamsim
