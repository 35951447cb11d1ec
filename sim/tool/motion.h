// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <iterator>
#include <optional>

#include "sim/base/error.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/pose_sequence.h"

namespace reamsim {

/// The path of a tool at the frame rate: poses[k] is the pose of frame `first_frame` + k, at time frame/frame_rate_hz.
struct Motion {
  double frame_rate_hz = 1000;
  PoseSequence poses;
  std::int64_t first_frame = 0;  ///< not 0 in later passes of a run
  int pass = 1;                  ///< number of the pass
  /// A tool that a hand pushes: `poses` are then those of a push without resistance (unresisted_poses()), and the
  /// run has others.
  std::shared_ptr<const PushPlan> push = {};

  [[nodiscard]] double frame_s() const { return 1.0 / frame_rate_hz; }
  [[nodiscard]] std::int64_t last_frame() const { return first_frame + std::ssize(poses) - 1; }
  /// `frame`: from first_frame to last_frame().
  [[nodiscard]] ToolPose pose_of(std::int64_t frame) const {
    return poses[static_cast<std::size_t>(frame - first_frame)];
  }
};

/// The transform from the frame of a scenario's poses to B; nullopt where they are in B. Throws InputError where
/// `frame: glenoid` has no glenoid frame.
std::optional<Rigid> bone_from_frame(PoseFrame frame, const std::optional<GlenoidFrame>& glenoid);

/// Resamples keyframes, plunge or recorded CSV to the frame rate, in B. Position and spindle speed are interpolated
/// linearly, orientation spherically; the spin angle is the integral of the speed. The last frame ends at or after the
/// motion: the tool rests at its last pose, with spin, until then. Rows of a long CSV are read again from the file,
/// which must not change. `from: contact` must have been resolved (sim/scene/first_contact.h). Throws InputError where
/// `frame: glenoid` has no glenoid frame.
Motion build_motion(const MotionSettings& settings, const std::optional<GlenoidFrame>& glenoid, Diagnostics& report);

}  // namespace reamsim
