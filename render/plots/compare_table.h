// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

namespace reamsim {

/// A column of a table of runs.
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
