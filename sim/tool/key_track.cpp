// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/key_track.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include "sim/base/text.h"

namespace reamsim {

namespace {

constexpr double kRadPerSPerRpm = 2 * std::numbers::pi / 60;

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

double spin_rad(double from_rpm, double to_rpm, double duration_s) {
  return 0.5 * (from_rpm + to_rpm) * kRadPerSPerRpm * duration_s;
}

TrackIntegrator::TrackIntegrator(std::optional<Rigid> bone_from_poses, double start_s, std::optional<KeyPose> before)
    : bone_from_poses_(std::move(bone_from_poses)), start_s_(start_s), before_(std::move(before)) {}

KeyPose TrackIntegrator::next(KeyPose key) {
  if (bone_from_poses_) {
    const Quat rotation(bone_from_poses_->linear());
    key.pose.position_mm = *bone_from_poses_ * key.pose.position_mm;
    key.pose.orientation = (rotation * key.pose.orientation).normalized();
  }
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
  report.note("motion: the first pose is at " + rounded_text(start_s) + " s; that is time 0 of the simulation");
}

}  // namespace reamsim
