// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/study/key_values.h"

namespace reamsim {

/// The table of a study.
struct CohortTable {
  Variation rows;
  std::vector<std::string> labels;             ///< by row; empty: no such column
  std::vector<std::string> places;             ///< by row: file and line
  std::vector<std::vector<Mistake>> mistakes;  ///< by row: cells that name no input file
};

/// Reads a CSV file whose columns are scenario keys, and one row per patient. An empty cell leaves the value of the
/// base scenario; a column `label` names the rows and is no key. Cells follow RFC 4180. A row
/// with a cell that names no input file (it does not exist, is a folder, has a variable that is not set) stays, with
/// its mistakes, so that the other rows run; values of other keys are checked with the scenario of their run.
/// `mistakes` gets those of the table itself, with line and key: rows of another length, unknown keys.
CohortTable read_cohort_table(const std::string& path, const KeyValues& values, MistakeList& mistakes);

}  // namespace reamsim
