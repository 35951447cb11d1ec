// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/study/study.h"

namespace reamsim {

/// One run of a study.
struct PlannedRun {
  int number = 0;                      ///< from 1, in the order of the plan
  std::vector<std::string> cells;      ///< by column of the plan
  std::vector<std::string> overrides;  ///< of the base scenario, "key=value"
  std::string place;                   ///< of its row in the table, for messages; "": none
  std::vector<Mistake> mistakes;       ///< of the cells of that row
};

/// All runs of a study, and their parameters as a table.
struct StudyPlan {
  std::vector<std::string> columns;  ///< `label` where the table has it; keys; parts of tilts and shifts
  std::vector<PlannedRun> runs;
};

/// Combines every level of `vary`, every row of the table and every sample: the first variation changes slowest,
/// samples fastest, so that runs with the same bone tend to be neighbours. The samples are the same for every
/// combination. A tilt or shift changes the vector that the run has otherwise, and adds columns of its independent
/// parts: KEY.tilt_1_deg, KEY.tilt_2_deg or KEY.shift_x_mm, _y, _z. `overrides`: for every run, after those of the
/// study. Throws InputError: too many runs, or a vector to change that neither the base scenario nor the study gives.
StudyPlan make_plan(const Study& study, const std::vector<std::string>& overrides = {});

}  // namespace reamsim
