#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/report.h"
#include "sim/motion/motion.h"

namespace reamsim {

/// A pose of the scenario at a time of its own; between two of them the motion is interpolated.
struct KeyPose {
  double time_s = 0;
  ToolPose pose;  ///< the spin angle is not used
};

/// The frame T whose +z is `tool_z` (any length > 0): x of T is the frame's x axis laid perpendicular to it, or its y
/// axis where x is nearly parallel. The same direction always gives the same frame.
Quat orientation_from_axis(const Vec3& tool_z);

/// Approach, feed, dwell and retract as key poses, starting at time 0.
std::vector<KeyPose> plunge_poses(const PlungeSettings& plunge);

/// Keyframes as key poses. Where keyframes give an axis, the tool tilts the shortest way from one to the next and does
/// not turn about its axis beside the spin. Throws InputError: fewer than two, time not increasing, no orientation.
std::vector<KeyPose> keyframe_poses(const std::vector<KeyframeSettings>& keyframes, Report& report);

/// Unit quaternion in the direction of `q`; `where` begins the message. Warns when |q| differs from 1 by more than
/// 10⁻³. Throws InputError when |q| is 0 or not finite.
Quat normalised(const Quat& q, const std::string& where, Report& report);

}  // namespace reamsim
