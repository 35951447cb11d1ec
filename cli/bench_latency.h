// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "cli/console.h"

namespace reamsim {

/// `reamsim bench --latency`: prints a line per scenario. Throws InputError, RunError, Interrupted.
void bench_latency(const std::vector<std::string>& scenarios, const std::string& device, const Console& console);

}  // namespace reamsim
