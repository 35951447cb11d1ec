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
  const Vec3 axis = plunge.axis.normalized();
  const double feed_mm = plunge.approach_mm + plunge.depth_mm;
  if (!(feed_mm > 0)) {
    throw InputError(SourceLocation{}, "motion.plunge.approach_mm + depth_mm", rounded_text(feed_mm),
                     "a number above 0 is needed");
  }
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
  std::vector<KeyPose> poses;
  std::optional<Vec3> last_axis;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const KeyframeSettings& k = keyframes[i];
    Quat orientation;
    if (k.quaternion) {
      orientation = normalized_or_warn(*k.quaternion, "motion.keyframes[" + std::to_string(i) + "].quaternion", report);
    } else {
      const Vec3 axis = k.axis->normalized();
      orientation = poses.empty() ? orientation_from_axis(axis)
                                  : smallest_rotation(*last_axis, axis) * poses.back().pose.orientation;
    }
    last_axis = orientation * Vec3::UnitZ();
    poses.push_back({k.time_s, {k.position_mm, orientation.normalized(), 0, k.spin_rpm}});
  }
  return poses;
}

}  // namespace reamsim
