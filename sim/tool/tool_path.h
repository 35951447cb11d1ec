// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "sim/tool/motion.h"

namespace reamsim {

/// Rotation vector (axis times angle, at most π) that takes orientation `a` to `b`, in B.
Vec3 rotation_vector(const Quat& a, const Quat& b);

/// Bound of the motion from `a` to `b` of a point within `reach_mm` of the tool's origin, without the spin, mm.
double motion_bound_mm(const ToolPose& a, const ToolPose& b, double reach_mm);

struct PathSample {
  ToolPose pose;
  std::size_t frame = 0;  ///< the frame at the pose or at the end of its segment
};

/// A path of the tool, parametrized by the accumulated motion_bound_mm().
class ToolPath {
 public:
  /// `points`: at least one.
  ToolPath(std::vector<PathSample> points, double reach_mm);

  [[nodiscard]] double length_mm() const { return ends_mm_.back(); }
  /// The frame at the end of the segment with `at_mm`.
  [[nodiscard]] std::size_t frame_at(double at_mm) const { return points_[point_at(at_mm)].frame; }
  [[nodiscard]] ToolPose pose_at(double at_mm) const;

 private:
  [[nodiscard]] std::size_t point_at(double at_mm) const;

  std::vector<PathSample> points_;
  std::vector<double> ends_mm_;  ///< by point
};

/// Chooses poses of a path at steps of motion_bound_mm(), and those where the tool stops or reverses.
class StepChooser {
 public:
  struct Choice {
    ToolPose last;           ///< the pose that was chosen before
    PathSample sample;       ///< the pose that is chosen
    std::int64_t parts = 1;  ///< bound of the motion between them in steps, rounded up
  };

  StepChooser(double reach_mm, double step_mm) : reach_mm_(reach_mm), step_mm_(step_mm) {}

  /// Adds the next pose of the path, and returns the one before it if that is chosen. The first pose is not returned.
  /// `keep`: the pose is chosen in any case.
  std::optional<Choice> add(const PathSample& sample, bool keep = false);
  /// Ends the path, and returns its last pose if that is chosen.
  std::optional<Choice> finish() { return pending_ ? decide(true) : std::nullopt; }
  /// The pose that was added last, unless it was the first one.
  [[nodiscard]] const std::optional<PathSample>& last() const { return pending_; }

 private:
  std::optional<Choice> decide(bool reverses);

  double reach_mm_;
  double step_mm_;
  std::optional<ToolPose> chosen_;     ///< the last one
  std::optional<PathSample> pending_;  ///< waits for the next pose, which says whether the tool reverses
  bool keep_pending_ = false;
  Vec3 before_mm_ = Vec3::Zero();  ///< position before the pending pose
};

/// Poses of StepChooser along a path of at least one point, with at most `step_mm` between two of them.
std::vector<PathSample> sample_path(const std::vector<PathSample>& path, double reach_mm, double step_mm);

/// Collects the poses of a path in bounded memory: all up to 100,000; of a longer path those that StepChooser chooses,
/// the last one and those of given frames. The step doubles whenever there are too many.
class BoundedPath {
 public:
  static constexpr std::size_t kMost = 100'000;  ///< 10 MB

  /// `step_mm`: the first step, a bound of motion_bound_mm() for `reach_mm`. `keep`: frames that are kept, ascending.
  BoundedPath(double reach_mm, double step_mm, std::vector<std::int64_t> keep = {}, std::size_t most = kMost)
      : reach_mm_(reach_mm), step_mm_(step_mm), keep_(std::move(keep)), most_(most) {}

  void add(const ToolPose& pose, std::size_t frame);
  void add(const PoseSequence& poses) {
    for (std::size_t k = 0; k < poses.size(); ++k) add(poses[k], k);
  }
  /// Ends the path, and returns the poses that were kept; the first and the last are among them.
  std::vector<PathSample> finish();
  /// The step after the last pose; the first one as long as all poses are kept.
  [[nodiscard]] double step_mm() const { return step_mm_; }
  /// Bound of the motion from a pose that is not kept to the nearest one that is: the sum of all steps so far.
  [[nodiscard]] double deviation_mm() const { return thinned_ ? 2 * step_mm_ : 0; }

 private:
  void choose(const PathSample& sample);
  void choose_again();

  double reach_mm_;
  double step_mm_;
  std::vector<std::int64_t> keep_;
  std::size_t most_;
  std::vector<PathSample> samples_;
  bool thinned_ = false;
  std::optional<StepChooser> chooser_;  ///< none as long as all poses are kept
};

}  // namespace reamsim
