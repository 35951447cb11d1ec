// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <utility>
#include <vector>

namespace reamsim {

/// What the tables of a study take from summary.json.
struct RunSummary {
  /// Every number, with nested names joined by dots, but times and memory, which differ from run to run.
  std::vector<std::pair<std::string, double>> numbers;
  std::vector<std::string> warnings;
};

/// Reads the summary.json in a folder. Empty where the file is missing or damaged.
RunSummary read_run_summary(const std::string& run_dir);

/// Its numbers alone.
std::vector<std::pair<std::string, double>> summary_numbers(const std::string& run_dir);

}  // namespace reamsim
