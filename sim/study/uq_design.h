// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "sim/study/study_plan.h"

namespace reamsim {

/// An independent variable of an uncertainty analysis: a sampled number, or one part of a tilt or shift.
struct UncertainInput {
  std::string name;       ///< the key; of parts as in the columns of a plan
  std::size_t key = 0;    ///< index in the sample of the study
  bool constant = false;  ///< forces for other values follow from the force basis of a run, without another run
};

/// Whether a folder holds the runs of an uncertainty analysis, as UqDesign::write_runs() names them.
bool holds_uq_runs(const std::string& dir);
/// Whether it does, and their forces are those of the base's force law: sampled constants of the law have no runs.
bool has_forces_of_base_law(const Study& runs, const std::string& dir);

/// Whether a result of a study's table, such as "forces.peak_force_n", follows from the constants of the force law.
bool depends_on_law(const std::string& name);

/// The points at which bands and sensitivity indices need the outputs of a study, and their runs.
class UqDesign {
 public:
  using Point = std::vector<double>;  ///< of the unit cube, by input

  /// Throws InputError unless the study consists of samples alone, each within the range of its key.
  explicit UqDesign(Study study);

  [[nodiscard]] const std::vector<UncertainInput>& inputs() const { return inputs_; }
  /// Of two independent samples A and B of the unit cube the rows, and for every input those of A with its column of B.
  [[nodiscard]] const std::vector<Point>& points() const { return points_; }
  [[nodiscard]] int samples() const { return study_.sample->n; }
  [[nodiscard]] std::size_t runs() const { return run_points_.size(); }
  /// The run of a point. Its number in the study of runs is one more.
  [[nodiscard]] std::size_t run_of(const Point& point) const { return run_places_.at(run_part(point)); }
  [[nodiscard]] std::vector<std::pair<std::string, double>> constants(const Point& point) const;
  /// Whether forces come from the force basis of the runs: some inputs are constants. Otherwise from their forces.csv.
  [[nodiscard]] bool needs_basis() const;
  /// Throws InputError where a scenario refuses a run: no band or index follows from the rest.
  void require_valid_runs() const;
  /// Writes DIR/runs.yaml, a study of the runs, and its table. Returns its path. Throws RunError.
  [[nodiscard]] std::string write_runs(const std::string& dir) const;

 private:
  void require_samples_in_range() const;
  [[nodiscard]] Study study_of_runs() const;
  [[nodiscard]] Point run_part(const Point& point) const;

  Study study_;
  std::vector<UncertainInput> inputs_;
  std::vector<Point> points_;
  std::vector<Point> run_points_;  ///< coordinates of the inputs that are no constants
  std::map<Point, std::size_t> run_places_;
};

}  // namespace reamsim
