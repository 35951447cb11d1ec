// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>

namespace reamsim {

/// The text of a scenario: of a file, or of a pipe (`reamsim run <(command)`). Ends after more than `most_bytes`, so
/// that a file without an end is seen to be too large. Throws InputError, also for a pipe into which nothing is written
/// for ten seconds.
std::string read_scenario_text(const std::string& path, std::size_t most_bytes);

}  // namespace reamsim
