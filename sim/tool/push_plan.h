// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/pose_sequence.h"

namespace reamsim {

/// The thrust of a hand over time.
class ThrustProfile {
 public:
  explicit ThrustProfile(double thrust_n) : times_s_{0}, thrusts_n_{thrust_n} {}
  /// Reads a CSV with the columns time_s (ascending) and thrust_n (0 or more). Throws InputError with file and line.
  explicit ThrustProfile(const std::string& path);

  /// Linear between the rows, constant before the first and after the last.
  [[nodiscard]] double at(double time_s) const;
  [[nodiscard]] double most_n() const;

 private:
  std::vector<double> times_s_, thrusts_n_;
};

/// A tool that advances less under thrust stands still, mm/s; after this time it has stalled.
inline constexpr double kStill_mm_s = 1e-3, kStall_s = 0.1;

/// A push along a line, in B. How far the tool is at a time is known only when the bone has answered.
class PushPlan {
 public:
  /// `bone_from_poses`: nullopt where the settings are in B. The depth counts from entry_mm: `from: contact` must have
  /// been resolved. Throws InputError for a profile that cannot be read.
  PushPlan(const PushSettings& settings, double frame_rate_hz, const std::optional<Rigid>& bone_from_poses);

  /// The pose after `travel_mm` along the line, at a time from the start.
  [[nodiscard]] ToolPose pose(double travel_mm, double time_s) const;
  [[nodiscard]] double thrust_n(double time_s) const { return thrust_.at(time_s); }
  [[nodiscard]] const PushSettings& settings() const { return settings_; }
  /// The push ends after this frame in any case.
  [[nodiscard]] std::int64_t last_frame() const { return last_frame_; }
  /// And at this travel.
  [[nodiscard]] double last_travel_mm() const { return last_travel_mm_; }
  [[nodiscard]] const Vec3& axis() const { return axis_; }

 private:
  PushSettings settings_;
  ThrustProfile thrust_;
  Vec3 start_mm_;
  Vec3 axis_;
  Quat orientation_;
  std::int64_t last_frame_;
  double last_travel_mm_;
};

/// The poses of a push that meets no resistance: the shortest in time, over the longest way. For forecasts, which only
/// need the way.
PoseSequence unresisted_poses(std::shared_ptr<const PushPlan> plan, double frame_rate_hz);

}  // namespace reamsim
