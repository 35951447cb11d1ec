// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/tool/motion.h"

namespace reamsim {

/// A pose of the scenario at a time; the motion interpolates between key poses.
struct KeyPose {
  double time_s = 0;
  ToolPose pose;  ///< the spin angle is not used
};

/// Approach, feed, dwell and retract as key poses from time 0. Throws InputError where approach and depth are 0.
std::vector<KeyPose> plunge_poses(const PlungeSettings& plunge);

/// Keyframes as key poses. Between axes the tool tilts along the shortest rotation, without rotation about its axis
/// beside the spin. The scenario has been validated: two or more, in ascending time. Throws as normalized_or_warn().
std::vector<KeyPose> keyframe_poses(const std::vector<KeyframeSettings>& keyframes, Diagnostics& report);

/// `q` normalized. Warns when |q| differs from 1 by more than 10⁻³. Throws InputError when |q| is 0 or not finite.
/// Messages begin with `where`.
Quat normalized_or_warn(const Quat& q, const std::string& where, Diagnostics& report);

/// Takes a pose to the frame of `to`.
inline void move_pose(const Rigid& to, ToolPose& pose) {
  pose.position_mm = to * pose.position_mm;
  pose.orientation = (Quat(to.linear()) * pose.orientation).normalized();
}

/// Two successive key poses.
struct KeySegment {
  KeyPose begin;
  KeyPose end;
};

/// The key poses of a motion in B: from time 0, with the spin angle. Any thread may call at().
struct KeyTrack {
  double end_s = 0;
  std::function<KeySegment(double time_s)> at;  ///< the segment of a time, the last one for later times
};

/// The segment of a time among `keys`, at least two.
KeySegment segment_at(const std::vector<KeyPose>& keys, double time_s);

/// Takes key poses of a scenario to those of a track: from the frame of the poses to B, and from the time of the first
/// one. `next` must be called with them in their order.
struct TrackIntegrator {
  std::optional<Rigid> bone_from_poses;  ///< nullopt if the poses are in B
  double start_s = 0;
  std::optional<KeyPose> before{};  ///< the pose that next() has returned last

  KeyPose next(KeyPose key);
};

/// A track in memory, of at least two poses that next() of an integrator has returned.
KeyTrack store_track(std::vector<KeyPose> keys);

/// The rows of a recorded CSV as the settings describe them (docs/inputs.md), with columns in any order; others are
/// ignored with a note. The poses are those of the tool in the frame of motion.frame: units, registration and
/// calibration are applied. With a max_gap_s rows without a pose are skipped. Throws InputError with file and line: as
/// CsvReader, position beyond a kilometre, zero quaternion, times that do not increase or have a gap of more than
/// max_gap_s, fewer than two or more than ten million rows.
std::vector<KeyPose> read_pose_csv(const CsvMotionSettings& settings, Diagnostics& report);

/// The track of a recorded CSV. A file of up to 100,000 rows is read into memory, and so is one that can be read only
/// once, such as a pipe. For a longer one the track holds an index, and reads blocks of rows again; throws as
/// read_pose_csv(). Notes another start than time 0.
KeyTrack open_csv_track(const CsvMotionSettings& settings, const std::optional<Rigid>& bone_from_poses,
                        Diagnostics& report);

/// Notes that time 0 of the simulation is the first pose, where that is at `start_s`.
void note_start(double start_s, Diagnostics& report);

}  // namespace reamsim
