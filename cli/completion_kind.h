// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "cli/command_line.h"

namespace reamsim {

/// What a shell can complete for the value of an argument.
enum class Completed { nothing, choices, commands, scenarios, studies, folders, files, files_and_scenarios };

/// By the name of its value, such as DIR or FILE.csv.
inline Completed completed_by(const ArgumentText& argument) {
  if (!argument.choices.empty()) return Completed::choices;
  const std::string& value = argument.value;
  if (value == "COMMAND") return Completed::commands;
  if (value.starts_with("SCENARIO")) return Completed::scenarios;
  if (value == "STUDY") return Completed::studies;
  // A bone, which may also be that of a scenario: the description says where a name is taken.
  if (value == "INPUT" && argument.description.find("shipped") != std::string::npos) {
    return Completed::files_and_scenarios;
  }
  if (value == "DIR") return Completed::folders;
  const bool file = value.starts_with("FILE") || value == "MESH" || value == "INPUT" || value == "MEASURED.csv";
  return file ? Completed::files : Completed::nothing;
}

}  // namespace reamsim
