// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/base/mistake_list.h"
#include "sim/study/key_values.h"

namespace reamsim {

/// The table of a study.
struct CohortTable {
  Variation rows;
  std::vector<std::string> labels;    ///< by row; empty: no such column
  std::vector<std::string> places;    ///< by row: file and line
  std::vector<std::string> mistakes;  ///< by row: files that do not exist; "": none
};

/// Reads a CSV file whose columns are scenario keys, and one row per patient. An empty cell leaves the value of the
/// base scenario; a column `label` names the rows and is no key. Cells follow RFC 4180. A row
/// that names a file that does not exist stays, with its mistake. Lists other mistakes with line and key.
CohortTable read_cohort_table(const std::string& path, const KeyValues& values, MistakeList& mistakes);

}  // namespace reamsim
