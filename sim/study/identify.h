// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/scenario/scenario.h"
#include "sim/study/study_plan.h"

namespace reamsim {

/// A planned run with the name of its folder.
struct IdentifiedRun {
  std::string id;       ///< run_id(); "" where the scenario is wrong
  std::string mistake;  ///< then why: all mistakes of its row and its scenario, on one line
};

/// Parses the scenario of every run, as a command does that runs it alone. `done`: called with the number of finished
/// runs.
std::vector<IdentifiedRun> identify_runs(const Study& study, const StudyPlan& plan,
                                         const std::function<void(std::size_t)>& done = {});

/// The runs with the folder of this one, itself among them: a table may have a patient twice.
std::vector<std::size_t> rows_of_run(const std::vector<IdentifiedRun>& runs, std::size_t run);

/// "runs 3 and 7 are the same run", a line for each such group, of at most three.
std::vector<std::string> same_runs(const std::vector<IdentifiedRun>& runs);

/// The scenario of a run. Throws InputError.
Scenario scenario_of(const Study& study, const PlannedRun& run);

}  // namespace reamsim
