// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/console.h"
#include "sim/run/cost_estimate.h"
#include "sim/study/study_folder.h"
#include "sim/study/study_plan.h"

namespace CLI {
class App;
}

namespace reamsim {

/// The arguments of the commands of `sweep`.
struct SweepOptions {
  std::string file;
  std::string output;
  std::vector<std::string> overrides = {};
  int jobs = 1;
  std::vector<std::string> devices = {};  ///< in place of engine.device, one worker each in turn; none: engine.device
  std::string shard = {};
  bool shows_table = true;  ///< prints main effects and paths

  /// Adds those that all commands share.
  void add_to(CLI::App& command);
  /// One for each job, and for each device at least.
  [[nodiscard]] int workers() const { return std::max(jobs, static_cast<int>(devices.size())); }
  /// DIR of -o, else out/NAME of the study.
  [[nodiscard]] std::string dir(const Study& study) const { return output.empty() ? "out/" + study.name : output; }
};

/// A study, its plan, and the names of its runs.
struct SweepRuns {
  Study study;
  StudyPlan plan;
  std::vector<IdentifiedRun> runs;
};

/// Simulates the runs that are not done, and collects them. Throws RunError where some fail, and Suspended.
SweepRuns simulate_study(const SweepOptions& options, const Console& console);

/// The option --jobs.
void add_jobs(CLI::App& command, int& jobs);

/// Each adds one command below `reamsim sweep`; the others are in sweep.cpp.
void add_sweep_submit(CLI::App& sweep, Console& console);
void add_sweep_worker(CLI::App& sweep);

// `sweep` and `uq` write files of the same names into the folder of a study, which must not replace one another.

/// Whether a folder holds the runs of an uncertainty analysis.
bool holds_uq_runs(const std::string& dir);

/// Throws InputError where `dir` holds an analysis of `uq`, unless the study is that of its own runs (runs.yaml).
void keep_results_of_uq(const SweepOptions& options, const std::string& dir);

/// Throws InputError where `dir` holds runs of a study that is no analysis of `uq`.
void keep_results_of_sweep(const std::string& dir);

/// Whether holds_uq_runs(), and their forces are those of the base's force law:
/// sampled constants of the law have no runs.
bool has_forces_of_base_law(const Study& runs, const std::string& dir);

/// Whether a result of a study's table, such as "forces.peak_force_n", follows from the constants of the force law.
bool depends_on_law(const std::string& name);

/// Writes runs.csv, effects.* and sweep.html into the folder, and prints counts, a table and the paths. Throws
/// RunError.
void collect_and_show(const SweepRuns& sweep, const StudyFolder& folder, const Console& console);

/// "36 runs: 36 done, 0 failed, 0 interrupted, 0 missing".
std::string counts_text(const StudyCounts& counts);

/// Prints this sentence and the first warnings, where runs have any.
void warn_of_runs(const RunMessages& messages, const std::string& sentence, const Console& console);

/// What a worker says of a run: on one line the letter of the outcome, a space, and the text.
struct WorkerAnswer {
  enum class Outcome : char {
    done = 'd',
    failed = 'f',
    wrong_input = 'e',
    device_failed = 'l',
    busy = 'b',
    interrupted = 'i'
  };

  std::size_t run = 0;  ///< index in the plan
  Outcome outcome = Outcome::done;
  /// The message of a failure; of a check, its RunEstimate as JSON; of a run, whether it was continued, or "".
  std::string text;

  /// Also for a letter that is no outcome, such as the first of what a driver prints.
  [[nodiscard]] bool has_failed() const {
    return outcome != Outcome::done && outcome != Outcome::busy && outcome != Outcome::interrupted;
  }
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RunEstimate, load_s, simulate_s, memory_bytes, frames, warnings)

/// Distributes runs (indices in the plan) over SweepOptions::workers() processes of this program, at most one for each
/// run, which divide the processors among them. They simulate into the study's folder `dir`, or, where it is "", check.
/// Calls `answered` for each run, and shows on the console how many have been. A worker that ends by itself, or whose
/// device fails, fails its run and is replaced; where one of SweepOptions::devices fails three times in a row, others
/// take its runs. Returns false where stop_requested() ended the work and the workers. Throws RunError where no worker
/// can be started.
bool work_on(const SweepRuns& sweep, const std::vector<std::size_t>& runs, const SweepOptions& options,
             const std::string& dir, const Console& console, const std::function<void(const WorkerAnswer&)>& answered);

}  // namespace reamsim
