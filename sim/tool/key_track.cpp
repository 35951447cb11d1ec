// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/key_track.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

/// A quaternion whose norm deviates by more was not merely rounded.
constexpr double kUnitTolerance = 1e-3;
constexpr double kMinNorm = 1e-9;

}  // namespace

Quat normalized_or_warn(const Quat& q, const std::string& where, Diagnostics& report) {
  const double norm = q.norm();
  if (!(norm > kMinNorm) || !std::isfinite(norm))
    throw InputError(where + ": the quaternion has length " + rounded_text(norm) + "; a unit quaternion is needed");
  if (std::abs(norm - 1) > kUnitTolerance)
    report.warn(where + ": the quaternion has length " + rounded_text(norm) + " and was normalized");
  return Quat(q.coeffs() / norm);
}

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

namespace {

class StoredTrack final : public KeyTrack {
 public:
  explicit StoredTrack(std::vector<KeyPose> keys) : keys_(std::move(keys)) {}
  [[nodiscard]] double end_s() const override { return keys_.back().time_s; }
  [[nodiscard]] KeySegment at(double time_s) const override {
    const std::size_t i = segment_at(keys_, time_s);
    return {keys_[i], keys_[i + 1]};
  }

 private:
  std::vector<KeyPose> keys_;
};

}  // namespace

std::size_t segment_at(const std::vector<KeyPose>& keys, double time_s) {
  const auto after = std::ranges::upper_bound(keys, time_s, {}, &KeyPose::time_s) - keys.begin();
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - 1, 0, std::ssize(keys) - 2));
}

TrackIntegrator::TrackIntegrator(std::optional<Rigid> bone_from_poses, double start_s, std::optional<KeyPose> before)
    : bone_from_poses_(std::move(bone_from_poses)), start_s_(start_s), before_(std::move(before)) {}

KeyPose TrackIntegrator::next(KeyPose key) {
  if (bone_from_poses_) move_pose(*bone_from_poses_, key.pose);
  key.time_s -= start_s_;
  if (before_) {
    key.pose.spin_angle_rad = before_->pose.spin_angle_rad +
                              spin_rad(before_->pose.spin_rpm, key.pose.spin_rpm, key.time_s - before_->time_s);
  }
  before_ = key;
  return key;
}

std::unique_ptr<const KeyTrack> store_track(std::vector<KeyPose> keys) {
  return std::make_unique<const StoredTrack>(std::move(keys));
}

void note_start(double start_s, Diagnostics& report) {
  if (start_s == 0) return;
  report.note("motion: the first pose is at " + shortest_text(start_s) + " s; that is time 0 of the simulation");
}

}  // namespace reamsim
