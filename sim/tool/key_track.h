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

/// Spin angle at a linearly changing spindle speed, rad.
double spin_rad(double from_rpm, double to_rpm, double duration_s);

/// A track in memory, of at least two poses that next() of an integrator has returned.
std::unique_ptr<const KeyTrack> store_track(std::vector<KeyPose> keys);

/// The track of a recorded CSV. A file of up to 100,000 rows is read into memory, and so is one that can be read only
/// once, such as a pipe. For a longer one the track holds an index, and reads blocks of rows again; see read_pose_csv()
/// for what is thrown. Notes another start than time 0.
std::unique_ptr<const KeyTrack> open_csv_track(const CsvMotionSettings& settings,
                                               const std::optional<Rigid>& bone_from_poses, Diagnostics& report);

/// Notes that time 0 of the simulation is the first pose, where that is at `start_s`.
void note_start(double start_s, Diagnostics& report);

}  // namespace reamsim
