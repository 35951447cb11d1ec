// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "cli/sweep_options.h"
#include "sim/study/collect.h"

namespace reamsim {

/// Collects the runs of a study and shows them: writes runs.csv, effects.* and sweep.html into its folder, and prints
/// counts, a table and the paths. Throws RunError.
void collect_and_show(const SweepRuns& sweep, const StudyFolder& folder, const Console& console);

/// "36 runs: 36 done, 0 failed, 0 interrupted, 0 missing".
std::string counts_text(const StudyCounts& counts);

/// Prints this sentence and the first warnings, where runs have any.
void warn_of_runs(const RunMessages& messages, const std::string& sentence, const Console& console);

}  // namespace reamsim
