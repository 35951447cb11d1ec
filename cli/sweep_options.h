// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "cli/console.h"
#include "sim/study/identify.h"

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

}  // namespace reamsim
