// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/pictures/overlay.h"
#include "sim/record/force_log.h"

namespace reamsim {

/// Labels of a run's pictures from its force log. They need the complete log: the greatest force scales the arrows.
class Captions {
 public:
  using Values = std::vector<std::pair<std::string, std::string>>;  ///< name and number with unit

  /// `mean_travel_mm`: the tool's travel over which forces are averaged; 0: single frames. `arrows`: draw force arrows.
  Captions(ForceLog log, double mean_travel_mm, bool arrows);

  /// Values of a picture during the run.
  [[nodiscard]] Values at(const ForceRow& row) const;
  /// Values of a picture of the final state.
  [[nodiscard]] Values after(double deepest_mm) const;
  /// The bone's force on the tool, at the tool's tip; none if negligible.
  [[nodiscard]] std::optional<ForceArrow> arrow(const ForceRow& row) const;

  /// The log with means.
  [[nodiscard]] const ForceLog& log() const { return log_; }
  /// Key results of the run.
  [[nodiscard]] KeyResults headline() const { return key_results_of(log_, !mean_.empty()); }
  /// Prefix of the names of forces: "mean " or empty.
  [[nodiscard]] const std::string& mean() const { return mean_; }

 private:
  ForceLog log_;
  std::string mean_;
  bool arrows_;
  double max_force_n_ = 0;
};

}  // namespace reamsim
