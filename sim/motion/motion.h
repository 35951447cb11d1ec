#pragma once

#include <optional>

#include "sim/base/report.h"
#include "sim/motion/pose_sequence.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The tool's path at the frame rate: poses[k] is the pose at time k/frame_rate_hz.
struct Motion {
  double frame_rate_hz = 1000;
  PoseSequence poses;

  [[nodiscard]] double frame_s() const { return 1.0 / frame_rate_hz; }
};

/// The transform from the frame of a scenario's poses to B; nullopt where they are in B. Throws InputError where
/// `frame: glenoid` has no glenoid frame.
std::optional<Rigid> bone_from_frame(PoseFrame frame, const std::optional<GlenoidFrame>& glenoid);

/// Resamples keyframes, plunge or recorded CSV to the frame rate, in B. Position and spindle speed are interpolated
/// linearly, orientation spherically; the spin angle is the integral of the speed. The last frame ends at or after the
/// motion: the tool rests at its last pose, with spin, until then. Rows of a long CSV are not held in memory: they are
/// read again from the file, which must not change. The depth of a plunge counts from entry_mm here: `from: contact`
/// must have been resolved (sim/scene/first_contact.h). Throws InputError where `frame: glenoid` has no glenoid frame.
Motion build_motion(const MotionSettings& settings, const std::optional<GlenoidFrame>& glenoid, Report& report);

}  // namespace reamsim
