// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/study/column_names.h"
#include "sim/study/run_table.h"

namespace reamsim {

/// A parameter of a study that varies, as main effects see it.
struct EffectParameter {
  ColumnName name;
  std::vector<std::string> with;    ///< keys that vary together with it (zip, tables)
  bool is_number = false;           ///< `x` are its values; otherwise numbers of `levels`, from 1
  bool has_intervals = false;       ///< of many values: runs are grouped by intervals
  std::vector<std::string> levels;  ///< of groups without intervals, as shown_cell()
  std::vector<double> x;            ///< by run of MainEffects::runs
  std::vector<std::size_t> group;   ///< by run
};

/// A result that main effects show.
struct EffectResult {
  ColumnName name;
  std::vector<double> y;  ///< by run; NaN where it is missing
};

/// The runs of a parameter with one level, or with values in one interval.
struct EffectGroup {
  std::size_t level = 0;  ///< place in EffectParameter::levels
  double x = 0;           ///< the level, or the mean of its values
  double from = 0, to = 0;
  int runs = 0;
  double mean = 0;
  double sd = 0;  ///< standard deviation of the result over all else that varies; 0 for one run
};

/// What a parameter alone changes of a result.
struct MainEffect {
  std::vector<EffectGroup> groups;  ///< ascending by x
  /// Fraction of the variance of the result that the means of the groups explain (the correlation ratio); of intervals
  /// corrected for what random groups would explain (Kelley 1935). 0 where the result does not vary.
  double explained = 0;
};

/// Main effects of a study.
struct MainEffects {
  std::vector<std::size_t> runs;                 ///< those that are done, by their place in the table
  std::vector<EffectParameter> parameters;       ///< descending by explains()
  std::vector<EffectResult> results;             ///< headline_results() that vary
  std::vector<std::vector<MainEffect>> effects;  ///< effects[parameter][result]

  [[nodiscard]] bool empty() const { return parameters.empty() || results.empty(); }
  /// What a parameter explains: the mean of its fractions over the results.
  [[nodiscard]] double explains(std::size_t parameter) const;
};

/// The level of a group; "" for an interval.
std::string level_text(const EffectParameter& parameter, const EffectGroup& group);

/// The effects of all parameters with two or more values in the runs that are done. A number with more than eight
/// values is grouped by intervals with equally many of them. Texts with more than forty values, and texts that
/// differ in every run, are no parameters; of parameters that group the runs in the same way, the first stands for all.
MainEffects main_effects(const RunTable& table);

}  // namespace reamsim
