// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

namespace reamsim {

/// What people read for a column of runs.csv.
struct ColumnName {
  std::string key;   ///< "motion.plunge.depth_mm"
  std::string text;  ///< "plunge depth"
  std::string unit;  ///< "mm"; "" without

  /// "Plunge depth (mm)".
  [[nodiscard]] std::string title() const;
};

/// Names of columns. Those of headline results are fixed; others are made of the last parts of the key, as many as tell
/// them apart.
std::vector<ColumnName> column_names(const std::vector<std::string>& keys);

/// The results that figures and tables of a study show, in this order: force, torque, volume, depth, energy, and
/// planning numbers.
const std::vector<ColumnName>& headline_results();

/// A cell as tables and figures show it: a path is its file name without extension, a number has four digits.
std::string shown_cell(const std::string& cell);

}  // namespace reamsim
