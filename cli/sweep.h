// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "cli/console.h"
#include "sim/study/collect.h"
#include "sim/study/study_plan.h"

namespace CLI {
class App;
}

namespace reamsim {

/// The arguments that all commands of `sweep` share.
struct SweepOptions {
  std::string file;
  std::string output;
  std::vector<std::string> overrides;

  void add_to(CLI::App& command);
  /// DIR of -o, else out/NAME of the study.
  [[nodiscard]] std::string dir(const Study& study) const;
};

/// A study, its plan, and the names of its runs.
struct SweepRuns {
  Study study;
  StudyPlan plan;
  std::vector<IdentifiedRun> runs;
};

/// Reads the study and parses the scenarios of all runs. Throws InputError for a wrong study.
SweepRuns load_sweep(const SweepOptions& options);

/// Simulates the runs that are not done, and collects them. Throws RunError where some fail, Suspended when it is
/// interrupted.
SweepRuns simulate_study(const SweepOptions& options, int jobs, const Console& console);

/// The option --jobs.
void add_jobs(CLI::App& command, int& jobs);

/// Each adds one command below `reamsim sweep`; the others are in sweep.cpp.
void add_sweep_submit(CLI::App& sweep, Console& console);
void add_sweep_worker(CLI::App& sweep);

// `sweep run`, `sweep collect` and `uq` write tables and pages of the same names into the folder of a study. Where one
// replaced those of the other, the rest of the folder would contradict them.

/// Throws InputError where `dir` holds an analysis of `uq`, unless the study is that of its own runs (runs.yaml).
void keep_results_of_uq(const SweepOptions& options, const std::string& dir);

/// Throws InputError where `dir` holds runs of a study that is no analysis of `uq`.
void keep_results_of_sweep(const std::string& dir);

/// Collects the runs of a study and shows them: writes runs.csv, effects.* and sweep.html into its folder, and prints
/// counts, a table and the paths. Throws RunError.
void collect_and_show(const SweepRuns& sweep, const StudyFolder& folder, const Console& console);

/// "36 runs: 36 done, 0 failed, 0 interrupted, 0 missing".
std::string counts_text(const StudyCounts& counts);

/// Prints this sentence and the first warnings, where runs have any.
void warn_of_runs(const RunMessages& messages, const std::string& sentence, const Console& console);

}  // namespace reamsim
