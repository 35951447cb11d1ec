// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/key_poses.h"

#include <cmath>

#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

/// A quaternion whose norm deviates by more was not merely rounded.
constexpr double kUnitTolerance = 1e-3;
constexpr double kMinNorm = 1e-9;
/// With a larger x component of the axis, y is the reference direction.
constexpr double kNearlyParallel = 0.9;

void require(bool right, const std::string& key, const std::string& found, const std::string& expected) {
  if (!right) throw InputError(SourceLocation{}, key, found, expected);
}

void require_positive(double value, const std::string& key) {
  require(value > 0 && std::isfinite(value), key, rounded_text(value), "a number above 0 is needed");
}

Vec3 unit_axis(const Vec3& axis, const std::string& key) {
  require(axis.allFinite() && axis.norm() > kMinNorm, key, "no direction", "a vector longer than 0 is needed");
  return axis.normalized();
}

}  // namespace

Quat orientation_from_axis(const Vec3& tool_z) {
  const Vec3 z = tool_z.normalized();
  const Vec3 reference = std::abs(z.x()) < kNearlyParallel ? Vec3::UnitX() : Vec3::UnitY();
  Mat3 axes;
  axes.col(0) = (reference - reference.dot(z) * z).normalized();
  axes.col(1) = z.cross(axes.col(0));
  axes.col(2) = z;
  return Quat(axes).normalized();
}

Quat normalized_or_warn(const Quat& q, const std::string& where, Diagnostics& report) {
  const double norm = q.norm();
  if (!(norm > kMinNorm) || !std::isfinite(norm))
    throw InputError(where + ": the quaternion has length " + rounded_text(norm) + "; a unit quaternion is needed");
  if (std::abs(norm - 1) > kUnitTolerance)
    report.warn(where + ": the quaternion has length " + rounded_text(norm) + " and was normalized");
  return Quat(q.coeffs() / norm);
}

std::vector<KeyPose> plunge_poses(const PlungeSettings& plunge) {
  const Vec3 axis = unit_axis(plunge.axis, "motion.plunge.axis");
  require(plunge.entry_mm.allFinite(), "motion.plunge.entry_mm", "not a number", "three finite numbers are needed");
  require_positive(plunge.feed_mm_s, "motion.plunge.feed_mm_s");
  require_positive(plunge.retract_mm_s, "motion.plunge.retract_mm_s");
  const double feed_mm = plunge.approach_mm + plunge.depth_mm;
  require_positive(feed_mm, "motion.plunge.approach_mm + depth_mm");
  require(plunge.dwell_s >= 0, "motion.plunge.dwell_s", rounded_text(plunge.dwell_s), "0 or more is needed");
  require(plunge.retract_mm >= 0, "motion.plunge.retract_mm", rounded_text(plunge.retract_mm), "0 or more is needed");

  const Quat orientation = orientation_from_axis(-axis);
  std::vector<KeyPose> poses;
  double time = 0;
  const auto add = [&](double duration_s, double travel_mm) {
    time += duration_s;
    // A phase without duration, or too short to change the time, adds no pose, so that times keep increasing.
    if (!poses.empty() && !(time > poses.back().time_s)) return;
    poses.push_back({time, {plunge.entry_mm + travel_mm * axis, orientation, 0, plunge.spin_rpm}});
  };
  add(0, -plunge.approach_mm);
  add(feed_mm / plunge.feed_mm_s, plunge.depth_mm);
  add(plunge.dwell_s, plunge.depth_mm);
  add(plunge.retract_mm / plunge.retract_mm_s, plunge.depth_mm - plunge.retract_mm);
  return poses;
}

std::vector<KeyPose> keyframe_poses(const std::vector<KeyframeSettings>& keyframes, Diagnostics& report) {
  require(keyframes.size() >= 2, "motion.keyframes", std::to_string(keyframes.size()) + " keyframes",
          "at least two are needed");
  std::vector<KeyPose> poses;
  std::optional<Vec3> last_axis;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const KeyframeSettings& k = keyframes[i];
    const std::string where = "motion.keyframes[" + std::to_string(i) + "]";
    require(std::isfinite(k.time_s) && (i == 0 || k.time_s > keyframes[i - 1].time_s), where + ".time_s",
            rounded_text(k.time_s), "a time later than that of the previous keyframe is needed");
    require(k.position_mm.allFinite(), where + ".position_mm", "not a number", "three finite numbers are needed");
    require(std::isfinite(k.spin_rpm), where + ".spin_rpm", "not a number", "a finite number is needed");
    require(k.axis || k.quaternion, where, "no orientation", "axis (+z of the tool) or quaternion is needed");

    Quat orientation;
    if (k.quaternion) {
      orientation = normalized_or_warn(*k.quaternion, where + ".quaternion", report);
    } else {
      const Vec3 axis = unit_axis(*k.axis, where + ".axis");
      orientation = poses.empty() ? orientation_from_axis(axis)
                                  : smallest_rotation(*last_axis, axis) * poses.back().pose.orientation;
    }
    last_axis = orientation * Vec3::UnitZ();
    poses.push_back({k.time_s, {k.position_mm, orientation.normalized(), 0, k.spin_rpm}});
  }
  return poses;
}

}  // namespace reamsim
