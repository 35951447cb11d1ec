// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <vector>

#include "sim/tool/tool_path.h"

namespace reamsim {

/// Collects the poses of a path in bounded memory. A path of up to 100,000 poses keeps all of them. From a longer one
/// it keeps those at steps along the path, those where the tool stops or reverses, the last one and those of given
/// frames (see StepChooser). The step doubles whenever there are too many.
class BoundedPath {
 public:
  static constexpr std::size_t kMost = 100'000;  ///< 10 MB

  /// `step_mm`: the first step, a bound of motion_bound_mm() for `reach_mm`. `keep`: frames that are kept, ascending.
  BoundedPath(double reach_mm, double step_mm, std::vector<std::int64_t> keep = {}, std::size_t most = kMost);

  /// Adds the next pose.
  void add(const ToolPose& pose, std::size_t frame);
  /// Adds all poses of a motion.
  void add(const PoseSequence& poses);
  /// Ends the path, and returns the poses that were kept; the first and the last are among them.
  std::vector<PathSample> finish();
  /// The step after the last pose; the first one as long as all poses are kept.
  [[nodiscard]] double step_mm() const { return step_mm_; }
  /// Bound of the motion from a pose that is not kept to the nearest one that is: the sum of all steps so far.
  [[nodiscard]] double deviation_mm() const { return thinned_ ? 2 * step_mm_ : 0; }

 private:
  void choose(const PathSample& sample);
  void append(const std::optional<StepChooser::Choice>& choice);
  /// Chooses among the samples with the present step.
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
