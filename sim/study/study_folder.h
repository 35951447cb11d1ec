// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "sim/scenario/choices.h"
#include "sim/study/study_plan.h"

namespace reamsim {

/// What became of a run of a study.
enum class RunState { missing, interrupted, failed, done };
template <>
inline constexpr auto kChoiceNames<RunState> = name_list("missing", "interrupted", "failed", "done");

/// The folder of a study:
///
///     study.json       marks the folder, and names the study
///     runs/ID/         a finished run (run_id()); runs/ID.partial while it is simulated, or interrupted
///     failed/ID.json   why a run failed
///
/// Several processes may work on one study at a time; runs reserve their own folders.
class StudyFolder {
 public:
  /// Creates the folder where it does not exist. Throws InputError where it holds something that is no study.
  StudyFolder(const Study& study, const std::string& dir);
  /// An existing folder, which is only read. Throws InputError if it does not exist.
  static StudyFolder open(const Study& study, const std::string& dir);

  [[nodiscard]] const std::string& path() const { return dir_; }
  [[nodiscard]] std::string run_dir(const std::string& id) const { return dir_ + "/runs/" + id; }
  /// A run is done where it has all files that the study keeps.
  [[nodiscard]] RunState state(const std::string& id) const;
  /// The message of a run that failed; "" where it did not.
  [[nodiscard]] std::string failure(const std::string& id) const;
  void note_failure(const std::string& id, const std::string& message) const;
  void forget_failure(const std::string& id) const;
  /// Waits until all results are on the disk.
  void sync() const;

 private:
  StudyFolder(std::string dir, const KeptFiles& keep) : dir_(std::move(dir)), keep_(keep) {}
  void mark(const Study& study) const;

  std::string dir_;
  KeptFiles keep_;
};

/// SHA-256 of files by path, each computed once.
using Checksums = std::map<std::string, std::string>;

/// The name of a run's folder in a study: 16 hex digits of the SHA-256 of the version of the program and the resolved
/// scenario, in which the checksums of input files stand for their paths. The name of the scenario does not count; of
/// the output section only force_basis does, and the render section only where pictures are kept. Throws InputError
/// when an input cannot be read.
std::string run_id(const Scenario& scenario, const KeptFiles& keep, Checksums& checksums);

/// A line for the user where the folder has finished runs that are none of this plan; else "". Names at most three
/// differences from the most similar run of the plan: "bone.voxel_mm is 1 there and 0.5 in this plan".
std::string text_of_other_runs(const Study& study, const StudyPlan& plan, const std::vector<IdentifiedRun>& runs,
                               const StudyFolder& folder);

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

/// Which of `all` runs a table has: all, or `most` of them drawn at random, the same on every machine.
std::vector<bool> runs_of_table(std::size_t all, std::size_t most);

/// What people read for a column of runs.csv.
struct ColumnName {
  std::string key;   ///< "motion.plunge.depth_mm"
  std::string text;  ///< "plunge depth"
  std::string unit;  ///< "mm"; "" without

  [[nodiscard]] std::string title() const;
};

/// Names of columns: fixed for headline results, otherwise the last parts of the key, as many as tell them apart.
std::vector<ColumnName> column_names(const std::vector<std::string>& keys);

/// The results that figures and tables of a study show, in this order.
const std::vector<ColumnName>& headline_results();

/// A cell as tables and figures show it: a path is its file name without extension, a number has four digits.
std::string shown_cell(const std::string& cell);

/// Messages of runs, each text once, with the first run that has it: of many texts the first ten.
class RunMessages {
 public:
  static constexpr std::size_t kMost = 10;

  /// `number`: of a run; each run once.
  void add(int number, const std::vector<std::string>& messages);

  [[nodiscard]] int runs() const { return runs_; }
  /// "run 3 and 2 more: TEXT", at most `most`.
  [[nodiscard]] std::vector<std::string> lines(std::size_t most = kMost) const;

 private:
  struct Text {
    int number;
    int runs;
    std::string message;
  };
  std::vector<Text> texts_;
  int runs_ = 0;
};

/// Runs of a study by what became of them.
struct StudyCounts {
  int done = 0;
  int failed = 0;       ///< also those whose scenario is wrong
  int interrupted = 0;  ///< or being simulated
  int missing = 0;

  [[nodiscard]] int all() const { return done + failed + interrupted + missing; }
};

StudyCounts count_runs(const StudyFolder& folder, const std::vector<IdentifiedRun>& runs);

RunMessages warnings_of_runs(const StudyFolder& folder, const StudyPlan& plan, const std::vector<IdentifiedRun>& runs);

struct CollectedStudy {
  StudyCounts counts;
  RunTable table;
  RunMessages warnings;  ///< of runs that are done
};

/// Writes DIR/runs.csv (docs/study-files.md), a row for each run of the plan. Reads one summary at a time. Returns the
/// rows, at most `most_in_table` (runs_of_table()). Throws RunError.
CollectedStudy collect_runs(const StudyFolder& folder, const StudyPlan& plan, const std::vector<IdentifiedRun>& runs,
                            std::size_t most_in_table = 50'000);

/// What the tables of a study take from summary.json.
struct RunSummary {
  /// Every number, with nested names joined by dots, but times and memory, which differ from run to run.
  std::vector<std::pair<std::string, double>> numbers;
  std::vector<std::string> warnings;
};

/// Reads the summary.json in a folder. Empty where the file is missing or damaged.
RunSummary read_run_summary(const std::string& run_dir);

}  // namespace reamsim
