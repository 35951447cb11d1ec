// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/yaml_tree.h"
#include "sim/study/study.h"

namespace reamsim {

/// Makes the values of scenario keys from what a study or its table has.
class KeyValues {
 public:
  /// `folder`: of the study file, the base of relative paths in it.
  explicit KeyValues(std::string folder) : folder_(std::move(folder)) {}

  /// The value of `key` that `node` holds. Throws InputError: unknown key, or a text that names no input file.
  [[nodiscard]] KeyValue of_node(const std::string& key, const YamlNode& node, const SourceLocation& where) const;
  /// The value of `key` as the cell of a table has it; an empty one leaves the value of the base scenario.
  [[nodiscard]] KeyValue of_cell(const std::string& key, const std::string& cell, const SourceLocation& where) const;

 private:
  std::string folder_;
};

/// A node as YAML on one line: 0.25, "a b", [0, 0, 5].
std::string flow_text(const YamlNode& node);

/// Reads a CSV file whose columns are scenario keys, and one row per patient. An empty cell leaves the value of the
/// base scenario; a column `label` names the rows and is no key. Cells follow RFC 4180. A row
/// with a cell that names no input file (it does not exist, is a folder, has a variable that is not set) stays, with
/// its mistakes, so that the other rows run; values of other keys are checked with the scenario of their run.
/// `mistakes` gets those of the table itself, with line and key: rows of another length, unknown keys.
CohortTable read_cohort_table(const std::string& path, const KeyValues& values, MistakeList& mistakes);

}  // namespace reamsim
