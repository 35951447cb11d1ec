// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/motion.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "sim/base/text.h"
#include "sim/tool/key_track.h"

namespace reamsim {

namespace {

/// Besides frame 0.
constexpr double kMaxFrames = 1e7;
/// Tolerance of the last frame's time, frames: rounding must not add one.
constexpr double kEndSlack = 1e-6;
/// A key pose that the motion at the frame rate misses by more is warned of, mm.
constexpr double kMissedMm = 0.5;

ToolPose pose_between(const KeyPose& a, const KeyPose& b, double time_s) {
  ToolPose pose = interpolate(a.pose, b.pose, (time_s - a.time_s) / (b.time_s - a.time_s));
  pose.spin_angle_rad = a.pose.spin_angle_rad + spin_rad(a.pose.spin_rpm, pose.spin_rpm, time_s - a.time_s);
  return pose;
}

/// The pose of a track in a frame.
ToolPose pose_in_frame(const KeyTrack& track, std::size_t frame, double frame_rate_hz) {
  const double frame_time_s = static_cast<double>(frame) / frame_rate_hz;
  const double time_s = std::min(frame_time_s, track.end_s());
  const KeySegment keys = track.at(time_s);
  ToolPose pose = pose_between(keys.begin, keys.end, time_s);
  // The motion ends within the last frame: for the rest of that frame the tool only rotates.
  const double rest_s = frame_time_s - time_s;
  if (rest_s * frame_rate_hz > kEndSlack) pose.spin_angle_rad += spin_rad(pose.spin_rpm, pose.spin_rpm, rest_s);
  return pose;
}

std::size_t count_frames(double end_s, double frame_rate_hz) {
  const double frames = std::ceil(end_s * frame_rate_hz - kEndSlack) + 1;
  if (!(frames - 1 <= kMaxFrames))
    throw InputError(
        SourceLocation{}, "motion",
        rounded_text(end_s) + " s at " + rounded_text(frame_rate_hz) + " Hz are " + rounded_text(frames) + " frames",
        "at most ten million are supported: lower motion.frame_rate_hz or shorten the motion");
  return static_cast<std::size_t>(frames);
}

/// The poses of a plunge or of keyframes; empty for a CSV.
std::vector<KeyPose> read_key_poses(const MotionSettings& settings, Diagnostics& report) {
  if (settings.plunge) return plunge_poses(*settings.plunge);
  if (settings.csv) return {};
  if (!settings.keyframes.empty()) return keyframe_poses(settings.keyframes, report);
  throw InputError(SourceLocation{}, "motion", "the motion is missing", "give plunge, push, keyframes or csv");
}

/// Warns of a key pose between two frames that the straight way between them misses, such as the end of a plunge.
void warn_of_missed_keys(const std::vector<KeyPose>& keys, const Motion& motion, Diagnostics& report) {
  for (std::size_t i = 1; i + 1 < keys.size(); ++i) {
    const double frame = keys[i].time_s * motion.frame_rate_hz;
    const auto before = static_cast<std::size_t>(frame);
    if (before + 1 >= motion.poses.size()) continue;
    const ToolPose between =
        interpolate(motion.poses[before], motion.poses[before + 1], frame - static_cast<double>(before));
    const double missed_mm = (between.position_mm - keys[i].pose.position_mm).norm();
    if (missed_mm <= kMissedMm) continue;
    report.warn("motion: the pose at " + rounded_text(keys[i].time_s) +
                " s lies between two frames, which miss it by " + rounded_text(missed_mm) +
                " mm; raise motion.frame_rate_hz");
    return;
  }
}

Motion pushed_motion(const MotionSettings& settings, const std::optional<Rigid>& to_bone) {
  count_frames(settings.push->time_s, settings.frame_rate_hz);  // refuses too many
  auto plan = std::make_shared<const PushPlan>(*settings.push, settings.frame_rate_hz, to_bone);
  Motion motion{settings.frame_rate_hz, unresisted_poses(plan, settings.frame_rate_hz)};
  motion.push = std::move(plan);
  return motion;
}

}  // namespace

std::optional<Rigid> bone_from_frame(PoseFrame frame, const std::optional<GlenoidFrame>& glenoid) {
  if (frame != PoseFrame::glenoid) return std::nullopt;
  if (!glenoid) {
    throw InputError(SourceLocation{}, "motion.frame", "frame is glenoid but bone.glenoid is missing",
                     "add it, or use frame: bone");
  }
  return glenoid->bone_from_glenoid;
}

Motion build_motion(const MotionSettings& settings, const std::optional<GlenoidFrame>& glenoid, Diagnostics& report) {
  const std::optional<Rigid> to_bone = bone_from_frame(settings.frame, glenoid);
  if (settings.push) return pushed_motion(settings, to_bone);
  std::vector<KeyPose> keys = read_key_poses(settings, report);
  if (!settings.csv) {
    note_start(keys.front().time_s, report);
    TrackIntegrator integrator(to_bone, keys.front().time_s);
    for (KeyPose& key : keys) key = integrator.next(key);
  }
  const std::shared_ptr<const KeyTrack> track =
      settings.csv ? open_csv_track(*settings.csv, to_bone, report) : store_track(keys);
  const double rate_hz = settings.frame_rate_hz;
  const auto pose = [track, rate_hz](std::size_t k) { return pose_in_frame(*track, k, rate_hz); };
  Motion motion{rate_hz, PoseSequence(count_frames(track->end_s(), rate_hz), pose)};
  warn_of_missed_keys(keys, motion, report);
  return motion;
}

}  // namespace reamsim
