// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/motion.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <string_view>

#include "sim/base/csv.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

constexpr double kUnitTolerance = 1e-3;  // a quaternion whose norm deviates by more was not merely rounded
constexpr double kMinNorm = 1e-9;

constexpr const char* kExpectedFile = "a CSV of the thrust with the columns time_s and thrust_n";
constexpr std::size_t kMostRows = 1'000'000;
constexpr double kMostThrust_n = 10'000;

constexpr double kMaxFrames = 1e7;  // besides frame 0
constexpr double kEndSlack = 1e-6;  // tolerance of the last frame's time, frames: rounding must not add one
/// A key pose that the motion at the frame rate misses by more is warned of, mm.
constexpr double kMissedMm = 0.5;

/// `keys`: two or more, in B, from time 0, with the spin angle.
ToolPose pose_in_frame(const std::vector<KeyPose>& keys, std::size_t frame, double frame_rate_hz) {
  const double frame_time_s = static_cast<double>(frame) / frame_rate_hz;
  const double time_s = std::min(frame_time_s, keys.back().time_s);
  const auto after = std::ranges::upper_bound(keys, time_s, {}, &KeyPose::time_s);
  const auto end = std::clamp(after, keys.begin() + 1, keys.end() - 1);
  const KeyPose &a = *(end - 1), &b = *end;
  ToolPose pose = interpolate(a.pose, b.pose, (time_s - a.time_s) / (b.time_s - a.time_s));
  pose.spin_angle_rad = a.pose.spin_angle_rad + spin_rad(a.pose.spin_rpm, pose.spin_rpm, time_s - a.time_s);
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

/// Approach, feed, dwell and retract as key poses from time 0. Throws InputError where approach and depth are 0.
std::vector<KeyPose> plunge_poses(const PlungeSettings& plunge) {
  const Vec3 axis = plunge.axis.normalized();
  const double feed_mm = plunge.approach_mm + plunge.depth_mm;
  if (!(feed_mm > 0)) {
    throw InputError(SourceLocation{}, "motion.plunge.approach_mm + depth_mm", rounded_text(feed_mm),
                     "a number above 0 is needed");
  }
  const Quat orientation = orientation_from_axis(-axis);
  std::vector<KeyPose> poses;
  double time = 0;
  const auto add = [&](double duration_s, double travel_mm) {
    time += duration_s;
    // A phase without duration, or too short to change the time, adds no pose, so that times keep increasing.
    if (!poses.empty() && !(time > poses.back().time_s)) return;
    poses.push_back({time, {plunge.entry_mm + travel_mm * axis, orientation, 0, plunge.spin_rpm}});
  };
  add(0, -plunge.approach_mm);
  add(feed_mm / plunge.feed_mm_s, plunge.depth_mm);
  add(plunge.dwell_s, plunge.depth_mm);
  add(plunge.retract_mm / plunge.retract_mm_s, plunge.depth_mm - plunge.retract_mm);
  return poses;
}

/// Keyframes as key poses. Between axes the tool tilts along the shortest rotation, without rotation about its axis
/// beside the spin. The scenario has been validated: two or more, in ascending time. Throws as normalized_or_warn().
std::vector<KeyPose> keyframe_poses(const std::vector<KeyframeSettings>& keyframes, Diagnostics& report) {
  std::vector<KeyPose> poses;
  std::optional<Vec3> last_axis;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const KeyframeSettings& k = keyframes[i];
    Quat orientation;
    if (k.quaternion) {
      orientation = normalized_or_warn(*k.quaternion, "motion.keyframes[" + std::to_string(i) + "].quaternion", report);
    } else {
      const Vec3 axis = k.axis->normalized();
      orientation = poses.empty() ? orientation_from_axis(axis)
                                  : smallest_rotation(*last_axis, axis) * poses.back().pose.orientation;
    }
    last_axis = orientation * Vec3::UnitZ();
    poses.push_back({k.time_s, {k.position_mm, orientation.normalized(), 0, k.spin_rpm}});
  }
  return poses;
}

std::vector<KeyPose> read_key_poses(const MotionSettings& settings, Diagnostics& report) {
  if (settings.plunge) return plunge_poses(*settings.plunge);
  if (settings.csv) return read_pose_csv(*settings.csv, report);
  if (!settings.keyframes.empty()) return keyframe_poses(settings.keyframes, report);
  throw InputError(SourceLocation{}, "motion", "the motion is missing", "give plunge, push, keyframes or csv");
}

/// Takes key poses to B and to times from that of the first one, and integrates the spin angle.
void integrate(std::vector<KeyPose>& keys, const std::optional<Rigid>& bone_from_poses) {
  const double start_s = keys.front().time_s;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    KeyPose& key = keys[i];
    if (bone_from_poses) move_pose(*bone_from_poses, key.pose);
    key.time_s -= start_s;
    if (i == 0) continue;
    const KeyPose& before = keys[i - 1];
    key.pose.spin_angle_rad =
        before.pose.spin_angle_rad + spin_rad(before.pose.spin_rpm, key.pose.spin_rpm, key.time_s - before.time_s);
  }
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

ToolPose interpolate(const ToolPose& a, const ToolPose& b, double t) {
  ToolPose pose;
  pose.position_mm = a.position_mm + t * (b.position_mm - a.position_mm);
  pose.orientation = a.orientation.slerp(t, b.orientation).normalized();
  pose.spin_angle_rad = a.spin_angle_rad + t * (b.spin_angle_rad - a.spin_angle_rad);
  pose.spin_rpm = a.spin_rpm + t * (b.spin_rpm - a.spin_rpm);
  return pose;
}

PoseSequence::PoseSequence(std::vector<ToolPose> poses) : size_(poses.size()) {
  source_ = [all = std::make_shared<const std::vector<ToolPose>>(std::move(poses))](std::size_t k) {
    return (*all)[k];
  };
}

PoseSequence PoseSequence::part(std::size_t first, std::size_t count) const {
  PoseSequence out = *this;
  out.first_ += first;
  out.size_ = count;
  return out;
}

std::vector<ToolPose> PoseSequence::all() const {
  std::vector<ToolPose> out;
  out.reserve(size_);
  for (std::size_t k = 0; k < size_; ++k) out.push_back((*this)[k]);
  return out;
}

Quat normalized_or_warn(const Quat& q, const std::string& where, Diagnostics& report) {
  const double norm = q.norm();
  if (!(norm > kMinNorm) || !std::isfinite(norm))
    throw InputError(where + ": the quaternion has length " + rounded_text(norm) + "; a unit quaternion is needed");
  if (std::abs(norm - 1) > kUnitTolerance)
    report.warn(where + ": the quaternion has length " + rounded_text(norm) + " and was normalized");
  return Quat(q.coeffs() / norm);
}

void PushPlan::read_thrust(const std::string& path) {
  constexpr std::array<std::string_view, 2> kNames{"time_s", "thrust_n"};
  CsvReader csv(path, kNames, kExpectedFile);
  for (std::vector<double> row; csv.next(row);) {
    if (!times_s_.empty() && row[0] <= times_s_.back()) {
      throw InputError(csv.where(), "time_s", "found " + rounded_text(row[0]),
                       "a time later than that of the previous row, " + rounded_text(times_s_.back()) + " s");
    }
    if (row[1] < 0 || row[1] > kMostThrust_n) {
      throw InputError(csv.where(), "thrust_n", "found " + rounded_text(row[1]),
                       "a thrust from 0 to " + rounded_text(kMostThrust_n) + " N");
    }
    if (times_s_.size() == kMostRows) throw InputError(csv.where(), "", "has more than a million rows", "fewer rows");
    times_s_.push_back(row[0]);
    thrusts_n_.push_back(row[1]);
  }
  if (times_s_.empty()) throw InputError({path, 0, 0}, "", "has no rows", kExpectedFile);
}

double PushPlan::thrust_n(double time_s) const {
  const auto after = std::ranges::upper_bound(times_s_, time_s);
  if (after == times_s_.begin()) return thrusts_n_.front();
  if (after == times_s_.end()) return thrusts_n_.back();
  const auto i = static_cast<std::size_t>(after - times_s_.begin());
  const double part = (time_s - times_s_[i - 1]) / (times_s_[i] - times_s_[i - 1]);
  return thrusts_n_[i - 1] + part * (thrusts_n_[i] - thrusts_n_[i - 1]);
}

PushPlan::PushPlan(const PushSettings& settings, double frame_rate_hz, const std::optional<Rigid>& bone_from_poses)
    : settings_(settings) {
  if (settings.profile.empty()) {
    times_s_ = {0};
    thrusts_n_ = {settings.thrust_n};
  } else {
    read_thrust(settings.profile);
  }
  const Rigid to_bone = bone_from_poses.value_or(Rigid::Identity());
  const Vec3 axis = settings.axis.normalized();
  start_mm_ = to_bone * (settings.entry_mm - settings.approach_mm * axis);
  axis_ = to_bone.linear() * axis;
  orientation_ = Quat(to_bone.linear()) * orientation_from_axis(-axis);
  last_frame_ = static_cast<std::int64_t>(std::ceil(settings.time_s * frame_rate_hz - 1e-6));
  last_travel_mm_ = settings.until == PushEnd::depth ? settings.approach_mm + settings.depth_mm
                                                     : settings.time_s * settings.max_feed_mm_s;
}

ToolPose PushPlan::pose(double travel_mm, double time_s) const {
  return {.position_mm = start_mm_ + travel_mm * axis_,
          .orientation = orientation_,
          .spin_angle_rad = spin_rad(settings_.spin_rpm, settings_.spin_rpm, time_s),
          .spin_rpm = settings_.spin_rpm};
}

PoseSequence unresisted_poses(std::shared_ptr<const PushPlan> plan, double frame_rate_hz) {
  const double frame_s = 1 / frame_rate_hz, feed_mm_s = plan->settings().max_feed_mm_s;
  const double frames = std::ceil(plan->last_travel_mm() / (feed_mm_s * frame_s) - 1e-9);
  const auto size = static_cast<std::size_t>(std::min(frames, static_cast<double>(plan->last_frame()))) + 1;
  return {size, [plan = std::move(plan), frame_s, feed_mm_s](std::size_t k) {
            const double time_s = static_cast<double>(k) * frame_s;
            return plan->pose(std::min(time_s * feed_mm_s, plan->last_travel_mm()), time_s);
          }};
}

Quat orientation_from_axis(const Vec3& tool_z) {
  constexpr double kNearlyParallel = 0.9;  // with a larger x component, y is the reference direction
  const Vec3 z = tool_z.normalized();
  const Vec3 reference = std::abs(z.x()) < kNearlyParallel ? Vec3::UnitX() : Vec3::UnitY();
  Mat3 axes;
  axes.col(0) = (reference - reference.dot(z) * z).normalized();
  axes.col(1) = z.cross(axes.col(0));
  axes.col(2) = z;
  return Quat(axes).normalized();
}

double spin_rad(double from_rpm, double to_rpm, double duration_s) {
  constexpr double kRadPerSPerRpm = 2 * std::numbers::pi / 60;
  return 0.5 * (from_rpm + to_rpm) * kRadPerSPerRpm * duration_s;
}

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
  if (const double start_s = keys.front().time_s; start_s != 0) {
    report.note("motion: the first pose is at " + shortest_text(start_s) + " s; that is time 0 of the simulation");
  }
  integrate(keys, to_bone);
  const auto track = std::make_shared<const std::vector<KeyPose>>(std::move(keys));
  const double rate_hz = settings.frame_rate_hz;
  const auto pose = [track, rate_hz](std::size_t k) { return pose_in_frame(*track, k, rate_hz); };
  Motion motion{rate_hz, PoseSequence(count_frames(track->back().time_s, rate_hz), pose)};
  motion.key_bytes = track->size() * sizeof(KeyPose);
  if (!settings.csv) warn_of_missed_keys(*track, motion, report);
  return motion;
}

}  // namespace reamsim
