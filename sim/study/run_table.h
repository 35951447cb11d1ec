// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/study/study_folder.h"

namespace reamsim {

/// A run of a study, with its parameters and results.
struct CollectedRun {
  int number = 0;  ///< in the plan, from 1
  std::string id;  ///< "": its scenario is wrong
  RunState state = RunState::missing;
  std::string message;             ///< of a failure; of a run that is done its warnings
  std::vector<std::string> cells;  ///< by parameter
  std::vector<double> numbers;     ///< by result; NaN where it is missing
  bool has_report = false;         ///< report.html is in its folder
};

/// Runs of a study as a table: what runs.csv has, in memory. Of large studies it holds a part.
struct RunTable {
  std::vector<std::string> parameters;  ///< as StudyPlan::columns
  std::vector<std::string> results;     ///< numbers of summary.json that are not parameters
  std::vector<CollectedRun> runs;       ///< ascending by number
  std::size_t all = 0;                  ///< runs of the study
};

/// "missing", "interrupted", "failed" or "done".
const char* name_of(RunState state);

/// Which of `all` runs a table of at most `most` runs has: all of them, or that many drawn at random, the same on every
/// machine.
std::vector<bool> runs_of_table(std::size_t all, std::size_t most);

/// What people read for a column of runs.csv.
struct ColumnName {
  std::string key;   ///< "motion.plunge.depth_mm"
  std::string text;  ///< "plunge depth"
  std::string unit;  ///< "mm"; "" without

  /// "Plunge depth (mm)".
  [[nodiscard]] std::string title() const;
};

/// Names of columns. Those of headline results are fixed; others are made of the last parts of the key, as many as tell
/// them apart.
std::vector<ColumnName> column_names(const std::vector<std::string>& keys);

/// The results that figures and tables of a study show, in this order: force, torque, volume, depth, energy, and
/// planning numbers.
const std::vector<ColumnName>& headline_results();

/// A cell as tables and figures show it: a path is its file name without extension, a number has four digits.
std::string shown_cell(const std::string& cell);

}  // namespace reamsim
