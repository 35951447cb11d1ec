#pragma once

#include <optional>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/report.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Where the tool is at one instant: the frame T in B without the spin, and the spin about −z of T.
struct ToolPose {
  Vec3 position_mm = Vec3::Zero();
  Quat orientation = Quat::Identity();
  double spin_angle_rad = 0;  ///< accumulated, positive clockwise seen from the drill
  double spin_rpm = 0;

  [[nodiscard]] Rigid bone_from_tool() const {
    Rigid out = Rigid::Identity();
    out.linear() = orientation.toRotationMatrix();
    out.translation() = position_mm;
    return out;
  }
};

/// The tool's path at the frame rate: poses[k] is the pose at time k/frame_rate_hz.
struct Motion {
  double frame_rate_hz = 1000;
  std::vector<ToolPose> poses;

  [[nodiscard]] double frame_s() const { return 1.0 / frame_rate_hz; }
};

/// Resamples keyframes, plunge or recorded CSV to the frame rate, in B (from G where the scenario says so; InputError
/// when it does and there is no glenoid frame). Position is interpolated linearly, orientation spherically, spin speed
/// linearly, and the spin angle is its integral.
Motion build_motion(const MotionSettings& settings, const std::optional<GlenoidFrame>& glenoid, Report& report);

/// The pose a share `t` (0…1) of the way from `a` to `b`: orientation spherically, all else linearly, the spin angle
/// too (within a frame the spin speed hardly changes).
ToolPose interpolate(const ToolPose& a, const ToolPose& b, double t);

}  // namespace reamsim
