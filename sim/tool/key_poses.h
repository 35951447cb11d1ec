// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/diagnostics.h"
#include "sim/tool/motion.h"

namespace reamsim {

/// A pose of the scenario at a time; the motion interpolates between key poses.
struct KeyPose {
  double time_s = 0;
  ToolPose pose;  ///< the spin angle is not used
};

/// The frame T with +z along `tool_z` (any length > 0): x of T is the projection of the x axis, or of the y axis where
/// x is nearly parallel to `tool_z`.
Quat orientation_from_axis(const Vec3& tool_z);

/// Approach, feed, dwell and retract as key poses, starting at time 0. Throws InputError where approach and depth are
/// 0.
std::vector<KeyPose> plunge_poses(const PlungeSettings& plunge);

/// Keyframes as key poses. Between axes the tool tilts along the shortest rotation, without rotation about its axis
/// beside the spin. The scenario has been validated: two or more, in ascending time. Throws as normalized_or_warn().
std::vector<KeyPose> keyframe_poses(const std::vector<KeyframeSettings>& keyframes, Diagnostics& report);

/// `q` normalized. Warns when |q| differs from 1 by more than 10⁻³. Throws InputError when |q| is 0 or not finite.
/// Messages begin with `where`.
Quat normalized_or_warn(const Quat& q, const std::string& where, Diagnostics& report);

}  // namespace reamsim
