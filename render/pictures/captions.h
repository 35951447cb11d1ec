#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/pictures/overlay.h"
#include "sim/record/force_log.h"

namespace reamsim {

/// What a run's log has to say on its pictures: known when the run has ended, because arrows are drawn to the scale of
/// its greatest force, and boxes are as wide as its longest number.
class Captions {
 public:
  using Values = std::vector<std::pair<std::string, std::string>>;  ///< name and number with unit

  /// `mean_travel_mm`: forces are means over so much of the tool's travel; 0: single frames. `arrows`: whether any are
  /// wanted.
  Captions(ForceLog log, double mean_travel_mm, bool arrows);

  /// Of a picture along the run.
  [[nodiscard]] Values at(const ForceRow& row) const;
  /// The longest value that any picture along the run can show.
  [[nodiscard]] std::string widest() const;
  /// Of a picture of the last state, reamed so deep.
  [[nodiscard]] Values after(double deepest_mm) const;
  /// The bone's force on the tool, from the tool's tip; none where it is next to none.
  [[nodiscard]] std::optional<ForceArrow> arrow(const ForceRow& row) const;

  /// With the means filled in.
  [[nodiscard]] const ForceLog& log() const { return log_; }
  /// What the final pictures and the plots say of the whole run.
  [[nodiscard]] Headline headline() const { return headline_of(log_, !mean_.empty()); }
  /// Stands before the names of forces that are means.
  [[nodiscard]] const std::string& mean() const { return mean_; }

 private:
  ForceLog log_;
  std::string mean_;
  bool arrows_;
  double most_force_n_ = 0;
  ForceRow most_;  ///< with the greatest axial force and torque
};

}  // namespace reamsim
