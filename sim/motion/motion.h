#pragma once

#include <optional>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/report.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The pose of the tool: frame T in B without the spin, and the spin about −z of T.
struct ToolPose {
  Vec3 position_mm = Vec3::Zero();
  Quat orientation = Quat::Identity();
  double spin_angle_rad = 0;  ///< accumulated, positive clockwise seen from the drive
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

/// Resamples keyframes, plunge or recorded CSV to the frame rate, in B. Position and spindle speed are interpolated
/// linearly, orientation spherically; the spin angle is the integral of the speed. Throws InputError where `frame:
/// glenoid` has no glenoid frame.
Motion build_motion(const MotionSettings& settings, const std::optional<GlenoidFrame>& glenoid, Report& report);

/// The pose at fraction `t` (0…1) between `a` and `b`: orientation spherically, all else linearly.
ToolPose interpolate(const ToolPose& a, const ToolPose& b, double t);

}  // namespace reamsim
