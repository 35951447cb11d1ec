// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/pose_sequence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/tool/key_track.h"

namespace reamsim {

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
  for (const ToolPose& pose : *this) out.push_back(pose);
  return out;
}

namespace {

constexpr const char* kExpectedFile = "a CSV of the thrust with the columns time_s and thrust_n";
constexpr std::size_t kMostRows = 1'000'000;
constexpr double kMostThrust_n = 10'000;

}  // namespace

ThrustProfile::ThrustProfile(const std::string& path) {
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

double ThrustProfile::at(double time_s) const {
  const auto after = std::ranges::upper_bound(times_s_, time_s);
  if (after == times_s_.begin()) return thrusts_n_.front();
  if (after == times_s_.end()) return thrusts_n_.back();
  const auto i = static_cast<std::size_t>(after - times_s_.begin());
  const double part = (time_s - times_s_[i - 1]) / (times_s_[i] - times_s_[i - 1]);
  return thrusts_n_[i - 1] + part * (thrusts_n_[i] - thrusts_n_[i - 1]);
}

PushPlan::PushPlan(const PushSettings& settings, double frame_rate_hz, const std::optional<Rigid>& bone_from_poses)
    : settings_(settings),
      thrust_(settings.profile.empty() ? ThrustProfile(settings.thrust_n) : ThrustProfile(settings.profile)) {
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

}  // namespace reamsim
