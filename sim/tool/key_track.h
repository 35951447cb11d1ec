// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
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

/// The key poses of a motion in B: from time 0, with the spin angle. Any thread may call the methods.
class KeyTrack {
 public:
  virtual ~KeyTrack() = default;
  [[nodiscard]] virtual double end_s() const = 0;
  /// The segment of a time, the last one for later times.
  [[nodiscard]] virtual KeySegment at(double time_s) const = 0;
};

/// The index of the segment of a time among `keys`, at least two.
std::size_t segment_at(const std::vector<KeyPose>& keys, double time_s);

/// Takes key poses of a scenario to those of a track: from the frame of the poses to B, and from the time of the first
/// one. `next` must be called with them in their order.
class TrackIntegrator {
 public:
  /// `bone_from_poses`: nullopt if the poses are in B. Continues after `before`, a pose that next() has returned.
  TrackIntegrator(std::optional<Rigid> bone_from_poses, double start_s, std::optional<KeyPose> before = {});
  KeyPose next(KeyPose key);

 private:
  std::optional<Rigid> bone_from_poses_;
  double start_s_;
  std::optional<KeyPose> before_;
};

/// A track in memory, of at least two poses that next() of an integrator has returned.
std::unique_ptr<const KeyTrack> store_track(std::vector<KeyPose> keys);

/// The rows of a recorded CSV as the settings describe them: by default a header line and rows of
/// `time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz` and optionally `spin_rpm` (otherwise settings.spin_rpm), in any order of
/// columns; other columns are ignored with a note. A byte-order mark, CRLF, blank lines, comments (#) and blanks around
/// fields are tolerated. The poses are those of the tool in the frame of motion.frame: units, registration and
/// calibration of the settings are applied. With a max_gap_s rows without a pose are skipped. Throws InputError with
/// file and line: no such file, empty, missing or repeated column, wrong number of fields, not a finite number,
/// position beyond a kilometre, zero quaternion, times that do not increase or have a gap of more than max_gap_s, fewer
/// than two or more than ten million rows.
std::vector<KeyPose> read_pose_csv(const CsvMotionSettings& settings, Diagnostics& report);

/// The track of a recorded CSV. A file of up to 100,000 rows is read into memory, and so is one that can be read only
/// once, such as a pipe. For a longer one the track holds an index, and reads blocks of rows again; throws as
/// read_pose_csv(). Notes another start than time 0.
std::unique_ptr<const KeyTrack> open_csv_track(const CsvMotionSettings& settings,
                                               const std::optional<Rigid>& bone_from_poses, Diagnostics& report);

/// Notes that time 0 of the simulation is the first pose, where that is at `start_s`.
void note_start(double start_s, Diagnostics& report);

}  // namespace reamsim
