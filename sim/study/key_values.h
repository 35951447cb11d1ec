// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

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

}  // namespace reamsim
