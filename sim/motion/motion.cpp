#include "sim/motion/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/motion/key_poses.h"
#include "sim/motion/pose_csv.h"

namespace reamsim {

namespace {

constexpr double kMaxFrames = 1e7;
/// Tolerance of the last frame's time, frames: rounding must not drop it.
constexpr double kEndSlack = 1e-6;
constexpr double kRadPerSPerRpm = 2 * std::numbers::pi / 60;

std::vector<KeyPose> read_key_poses(const MotionSettings& settings, Report& report) {
  if (settings.plunge) return plunge_poses(*settings.plunge);
  if (settings.csv) return read_pose_csv(*settings.csv, report);
  if (!settings.keyframes.empty()) return keyframe_poses(settings.keyframes, report);
  throw InputError(SourceLocation{}, "motion", "the motion is missing", "give plunge, keyframes or csv");
}

void to_bone_frame(std::vector<KeyPose>& keys, const MotionSettings& settings,
                   const std::optional<GlenoidFrame>& glenoid) {
  if (settings.frame != PoseFrame::glenoid) return;
  if (!glenoid)
    throw InputError(SourceLocation{}, "motion.frame", "frame is glenoid but bone.glenoid is missing",
                     "add it, or use frame: bone");
  const Quat bone_from_glenoid(glenoid->bone_from_glenoid.linear());
  for (KeyPose& key : keys) {
    key.pose.position_mm = glenoid->bone_from_glenoid * key.pose.position_mm;
    key.pose.orientation = (bone_from_glenoid * key.pose.orientation).normalized();
  }
}

/// Time 0 of the simulation is the first pose.
void start_at_zero(std::vector<KeyPose>& keys, Report& report) {
  const double start = keys.front().time_s;
  if (start == 0) return;
  for (KeyPose& key : keys) key.time_s -= start;
  report.note("motion: the first pose is at " + rounded_text(start) + " s; that is time 0 of the simulation");
}

/// Spin angle at a linearly changing spindle speed.
double spin_rad(double from_rpm, double to_rpm, double duration_s) {
  return 0.5 * (from_rpm + to_rpm) * kRadPerSPerRpm * duration_s;
}

void integrate_spin(std::vector<KeyPose>& keys) {
  for (std::size_t i = 1; i < keys.size(); ++i) {
    const KeyPose& before = keys[i - 1];
    keys[i].pose.spin_angle_rad = before.pose.spin_angle_rad +
                                  spin_rad(before.pose.spin_rpm, keys[i].pose.spin_rpm, keys[i].time_s - before.time_s);
  }
}

ToolPose pose_between(const KeyPose& a, const KeyPose& b, double time_s) {
  ToolPose pose = interpolate(a.pose, b.pose, (time_s - a.time_s) / (b.time_s - a.time_s));
  pose.spin_angle_rad = a.pose.spin_angle_rad + spin_rad(a.pose.spin_rpm, pose.spin_rpm, time_s - a.time_s);
  return pose;
}

std::size_t count_frames(double end_s, double frame_rate_hz) {
  if (!(frame_rate_hz > 0) || !std::isfinite(frame_rate_hz))
    throw InputError(SourceLocation{}, "motion.frame_rate_hz", rounded_text(frame_rate_hz),
                     "a number above 0 is needed");
  const double frames = std::floor(end_s * frame_rate_hz + kEndSlack) + 1;
  if (!(frames <= kMaxFrames))
    throw InputError(
        SourceLocation{}, "motion",
        rounded_text(end_s) + " s at " + rounded_text(frame_rate_hz) + " Hz are " + rounded_text(frames) + " frames",
        "at most ten million are supported: lower motion.frame_rate_hz or shorten the motion");
  return static_cast<std::size_t>(frames);
}

}  // namespace

ToolPose interpolate(const ToolPose& a, const ToolPose& b, double t) {
  ToolPose pose;
  pose.position_mm = a.position_mm + t * (b.position_mm - a.position_mm);
  pose.orientation = a.orientation.slerp(t, b.orientation).normalized();
  pose.spin_angle_rad = a.spin_angle_rad + t * (b.spin_angle_rad - a.spin_angle_rad);
  pose.spin_rpm = a.spin_rpm + t * (b.spin_rpm - a.spin_rpm);
  return pose;
}

Motion build_motion(const MotionSettings& settings, const std::optional<GlenoidFrame>& glenoid, Report& report) {
  std::vector<KeyPose> keys = read_key_poses(settings, report);
  to_bone_frame(keys, settings, glenoid);
  start_at_zero(keys, report);
  integrate_spin(keys);

  Motion motion;
  motion.frame_rate_hz = settings.frame_rate_hz;
  const std::size_t frames = count_frames(keys.back().time_s, settings.frame_rate_hz);
  motion.poses.reserve(frames);
  std::size_t segment = 0;
  for (std::size_t k = 0; k < frames; ++k) {
    const double time = std::min(static_cast<double>(k) / settings.frame_rate_hz, keys.back().time_s);
    while (segment + 2 < keys.size() && time >= keys[segment + 1].time_s) ++segment;
    motion.poses.push_back(pose_between(keys[segment], keys[segment + 1], time));
  }
  return motion;
}

}  // namespace reamsim
