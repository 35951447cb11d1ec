// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

namespace reamsim {

struct ComparedRun {
  std::string dir;            ///< results folder
  std::string label;          ///< in legends and tables
  double mean_travel_mm = 0;  ///< tool travel over which forces are averaged; 0: single frames
};

/// A number of summary.json in all runs; NaN where missing.
struct ComparedMetric {
  std::string key;  ///< "forces.peak_force_n"
  std::vector<double> values;

  /// Run `i` minus the first one.
  [[nodiscard]] double difference(std::size_t i) const { return values[i] - values[0]; }
  /// As a fraction of the first one; NaN where that is 0.
  [[nodiscard]] double relative(std::size_t i) const;
};

/// A key of the scenario whose value differs between the runs.
struct ComparedParameter {
  std::string key;                  ///< "motion.plunge.depth_mm"
  std::vector<std::string> values;  ///< as in scenario.yaml, lists on one line; "" where a run lacks the key
  std::vector<double> numbers;      ///< the same as numbers; NaN where the value is none
  std::vector<std::string> shown;   ///< of paths the file name, where no two paths share one; else as `values`

  [[nodiscard]] bool is_number() const;
  [[nodiscard]] std::size_t distinct() const;
};

struct Comparison {
  std::vector<ComparedRun> runs;
  std::vector<ComparedParameter> parameters;
  std::vector<ComparedMetric> metrics;
  std::string color_by;  ///< key of a parameter or metric that colours the curves; "": chosen by colored_by()
};

/// All numbers of the runs' summary.json in file order, those of the first run first. Throws InputError.
std::vector<ComparedMetric> compare_summaries(const std::vector<ComparedRun>& runs);

/// The keys of the runs' scenario.yaml that differ, in file order, without those that change no number: `version`,
/// `name`, `output`, `render`. An input file that changed under one path is a parameter "KEY (contents)", the beginning
/// of its SHA-256. Throws InputError: missing or damaged.
std::vector<ComparedParameter> compare_scenarios(const std::vector<ComparedRun>& runs);

/// What a colour ramp shows: a number per run.
struct RampKey {
  std::string key;  ///< "" for the number of the run
  std::vector<double> values;
};

/// The number that colours the curves: `color_by`; otherwise, with more runs than there are line styles, the numeric
/// parameter that correlates most with the peak axial force by rank, or the number of the run. None: each run has a
/// line style of its own. Throws InputError when `color_by` is no number in these runs.
std::optional<RampKey> colored_by(const Comparison& comparison);

/// The number of line styles that can be told apart.
constexpr std::size_t kLineStyles = 20;

/// Writes to DIR: compare.csv (a row for each metric and run), runs.csv (a row for each run: parameters, then metrics),
/// curves.csv, and compare.png, .svg, .pdf and .gp: force, torque and removed volume of every run against time and
/// depth since first contact. Throws InputError (a damaged forces.csv, or as colored_by()), RunError (gnuplot, disk).
void write_comparison(const std::string& dir, const Comparison& comparison);

/// The characters of a UTF-8 text.
std::vector<std::string> characters_of(const std::string& text);

struct RunColumn {
  std::string key;                 ///< "motion.plunge.depth_mm"
  std::vector<std::string> cells;  ///< one per run
};

/// The lines of a table of runs, none wider than `width` characters. A row per column where that fits; otherwise a row
/// per run, wrapped into blocks of columns. Keys are shortened to their last parts, as many as tell them apart. What is
/// longer still is replaced by a number or letter, and listed below the table. Texts must be printable.
std::vector<std::string> run_table(const std::vector<std::string>& labels, const std::vector<RunColumn>& columns,
                                   std::size_t width);

}  // namespace reamsim
