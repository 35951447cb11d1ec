// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/glenoid_frame.h"

#include <cmath>

#include "sim/base/error.h"

namespace reamsim {

namespace {

/// Directions closer than about half a degree do not determine the third axis.
constexpr double kMinSine = 0.01;

[[noreturn]] void fail_frame(const std::string& key, const std::string& found, const std::string& expected) {
  throw InputError({}, key, found, expected);
}

Vec3 unit(const Vec3& v, const std::string& key) {
  const double length = v.norm();
  if (!std::isfinite(length) || length < 1e-9) fail_frame(key, "a vector of length 0", "expected a direction");
  return v / length;
}

/// +z along `normal`, +y the part of `superior` perpendicular to it.
GlenoidFrame make_frame(const Vec3& center_mm, const Vec3& normal, const Vec3& superior, const std::string& key) {
  const Vec3 across = superior - superior.dot(normal) * normal;
  if (across.norm() < kMinSine) {
    fail_frame(key, "parallel to the normal", "expected a direction across the glenoid's face");
  }
  const Vec3 y = across.normalized();
  GlenoidFrame out;
  out.bone_from_glenoid.linear() << y.cross(normal), y, normal;
  out.bone_from_glenoid.translation() = center_mm;
  return out;
}

GlenoidFrame frame_from_landmarks(const LandmarkSettings& marks) {
  const std::string key = "bone.glenoid.landmarks";
  const Vec3 lateral = unit(marks.glenoid_center_mm - marks.trigonum_spinae_mm, key + ".trigonum_spinae_mm");
  const Vec3 superior = unit(marks.glenoid_center_mm - marks.inferior_angle_mm, key + ".inferior_angle_mm");
  const Vec3 across = superior - superior.dot(lateral) * lateral;
  if (across.norm() < kMinSine) fail_frame(key, "three points on a line", "expected a triangle: the scapular plane");
  return make_frame(marks.glenoid_center_mm, lateral, superior, key);
}

}  // namespace

ScapularAxes axes_of(const GlenoidFrame& glenoid, BodySide side) {
  const Mat3 axes = glenoid.bone_from_glenoid.linear();
  return {.lateral = axes.col(2),
          .superior = axes.col(1),
          .anterior = side == BodySide::right ? Vec3(axes.col(0)) : Vec3(-axes.col(0))};
}

std::optional<GlenoidFrame> glenoid_frame(const GlenoidSettings& settings, BodySide side) {
  if (settings.near_mm) return std::nullopt;
  const bool any = settings.center_mm || settings.normal || settings.superior;
  if (!any && !settings.landmarks) return std::nullopt;
  if (side == BodySide::unknown) fail_frame("bone.side", "missing", "a glenoid frame needs left or right");
  if (settings.landmarks) {
    if (any) fail_frame("bone.glenoid", "directions and landmarks", "expected one of them");
    return frame_from_landmarks(*settings.landmarks);
  }
  if (!settings.center_mm) fail_frame("bone.glenoid.center_mm", "missing", "expected the glenoid's centre in mm");
  if (!settings.normal) fail_frame("bone.glenoid.normal", "missing", "expected the direction out of the face");
  if (!settings.superior) fail_frame("bone.glenoid.superior", "missing", "expected the superior direction");
  return make_frame(*settings.center_mm, unit(*settings.normal, "bone.glenoid.normal"),
                    unit(*settings.superior, "bone.glenoid.superior"), "bone.glenoid.superior");
}

}  // namespace reamsim
