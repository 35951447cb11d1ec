// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <utility>
#include <vector>

namespace reamsim {

/// Every number of the summary.json in a folder, with nested names joined by dots, but times and memory, which differ
/// from run to run. Empty where the file is missing or damaged.
std::vector<std::pair<std::string, double>> summary_numbers(const std::string& run_dir);

}  // namespace reamsim
