// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The pose of the tool: frame T in B without the spin, and the spin about −z of T.
struct ToolPose {
  Vec3 position_mm = Vec3::Zero();
  Quat orientation = Quat::Identity();
  double spin_angle_rad = 0;  ///< accumulated, positive clockwise seen from the drive
  double spin_rpm = 0;

  static auto fields(auto& p) {
    return std::tie(p.position_mm, p.orientation.w(), p.orientation.x(), p.orientation.y(), p.orientation.z(),
                    p.spin_angle_rad, p.spin_rpm);
  }
  [[nodiscard]] bool is_valid() const {
    return position_mm.allFinite() && orientation.coeffs().allFinite() && std::isfinite(spin_angle_rad) &&
           std::isfinite(spin_rpm);
  }

  [[nodiscard]] Rigid bone_from_tool() const { return Eigen::Translation3d(position_mm) * orientation; }
};

/// The pose at fraction `t` (0…1) between `a` and `b`: orientation spherically, all else linearly.
ToolPose interpolate(const ToolPose& a, const ToolPose& b, double t);

/// Computes pose `k` of a motion, from any thread. Throws RunError when a file of poses cannot be read any more.
using PoseSource = std::function<ToolPose(std::size_t k)>;

/// The poses of a motion, one per frame, computed when asked for, from any thread. Copies share the source.
class PoseSequence {
 public:
  PoseSequence() = default;
  PoseSequence(std::vector<ToolPose> poses);  // implicit
  PoseSequence(std::initializer_list<ToolPose> poses) : PoseSequence(std::vector(poses)) {}
  PoseSequence(std::size_t size, PoseSource source) : source_(std::move(source)), size_(size) {}

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  ToolPose operator[](std::size_t k) const { return source_(first_ + k); }
  [[nodiscard]] ToolPose front() const { return (*this)[0]; }
  [[nodiscard]] ToolPose back() const { return (*this)[size_ - 1]; }

  /// `count` poses from `first` on, which becomes pose 0.
  [[nodiscard]] PoseSequence part(std::size_t first, std::size_t count) const;
  [[nodiscard]] std::vector<ToolPose> all() const;

 private:
  PoseSource source_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

/// A tool that advances less under thrust stands still, mm/s; after this time it has stalled.
inline constexpr double kStill_mm_s = 1e-3, kStall_s = 0.1;

/// A push along a line, in B. How far the tool is at a time is known only when the bone has answered.
class PushPlan {
 public:
  /// `bone_from_poses`: nullopt where the settings are in B. The depth counts from entry_mm: `from: contact` must have
  /// been resolved. The profile is a CSV with the columns time_s (ascending) and thrust_n (0 or more). Throws
  /// InputError with its file and line.
  PushPlan(const PushSettings& settings, double frame_rate_hz, const std::optional<Rigid>& bone_from_poses);

  /// The pose after `travel_mm` along the line, at a time from the start.
  [[nodiscard]] ToolPose pose(double travel_mm, double time_s) const;
  /// Linear between the rows of the profile, constant before the first and after the last.
  [[nodiscard]] double thrust_n(double time_s) const;
  [[nodiscard]] const PushSettings& settings() const { return settings_; }
  /// The push ends after this frame in any case.
  [[nodiscard]] std::int64_t last_frame() const { return last_frame_; }
  /// And at this travel.
  [[nodiscard]] double last_travel_mm() const { return last_travel_mm_; }
  [[nodiscard]] const Vec3& axis() const { return axis_; }

 private:
  void read_thrust(const std::string& path);

  PushSettings settings_;
  std::vector<double> times_s_, thrusts_n_;
  Vec3 start_mm_;
  Vec3 axis_;
  Quat orientation_;
  std::int64_t last_frame_;
  double last_travel_mm_;
};

/// The poses of a push that meets no resistance, for forecasts, which only need the way.
PoseSequence unresisted_poses(std::shared_ptr<const PushPlan> plan, double frame_rate_hz);

/// T with +z along `tool_z`, any length: x is the projection of the x axis, or of y where x is nearly parallel to it.
Quat orientation_from_axis(const Vec3& tool_z);

/// Spin angle at a linearly changing spindle speed, rad.
double spin_rad(double from_rpm, double to_rpm, double duration_s);

/// The path of a tool at the frame rate: poses[k] is the pose of frame `first_frame` + k, at time frame/frame_rate_hz.
struct Motion {
  double frame_rate_hz = 1000;
  PoseSequence poses;
  std::int64_t first_frame = 0;  ///< not 0 in later passes of a run
  int pass = 1;                  ///< number of the pass
  /// A tool that a hand pushes: `poses` are then those of unresisted_poses(), and the run has others.
  std::shared_ptr<const PushPlan> push = {};
  std::size_t key_bytes = 0;  ///< memory of the key poses

  [[nodiscard]] double frame_s() const { return 1.0 / frame_rate_hz; }
  [[nodiscard]] std::int64_t last_frame() const { return first_frame + std::ssize(poses) - 1; }
  /// `frame`: from first_frame to last_frame().
  [[nodiscard]] ToolPose pose_of(std::int64_t frame) const {
    return poses[static_cast<std::size_t>(frame - first_frame)];
  }
};

/// To B from the frame of poses; nullopt where they are in B. Throws InputError for `glenoid` without a glenoid frame.
std::optional<Rigid> bone_from_frame(PoseFrame frame, const std::optional<GlenoidFrame>& glenoid);

/// Resamples keyframes, plunge or recorded CSV to the frame rate, in B, as interpolate(); the spin angle is the
/// integral of the speed. The last frame ends at or after the motion: the tool rests at its last pose, with spin, until
/// then. `from: contact` must have been resolved (sim/scene/scene.h). Throws InputError where `frame: glenoid` has no
/// glenoid frame.
Motion build_motion(const MotionSettings& settings, const std::optional<GlenoidFrame>& glenoid, Diagnostics& report);

// What build_motion() is made of.

/// A pose of the scenario at a time; the motion interpolates between key poses.
struct KeyPose {
  double time_s = 0;
  ToolPose pose;  ///< the spin angle is not used
};

/// `q` normalized, with a warning where |q| is not 1 (±10⁻³). Throws InputError for 0 or not finite. `where`: for
/// messages.
Quat normalized_or_warn(const Quat& q, const std::string& where, Diagnostics& report);

/// Takes a pose to the frame of `to`.
inline void move_pose(const Rigid& to, ToolPose& pose) {
  pose.position_mm = to * pose.position_mm;
  pose.orientation = (Quat(to.linear()) * pose.orientation).normalized();
}

/// The rows of a recorded CSV as the settings describe them (docs/inputs.md), with columns in any order; others are
/// ignored with a note. The poses are those of the tool in the frame of motion.frame: units, registration and
/// calibration are applied. With a max_gap_s rows without a pose are skipped. Throws InputError with file and line: as
/// CsvReader, position beyond a kilometre, zero quaternion, times that do not increase or have a gap of more than
/// max_gap_s, fewer than two or more than ten million rows.
std::vector<KeyPose> read_pose_csv(const CsvMotionSettings& settings, Diagnostics& report);

}  // namespace reamsim
