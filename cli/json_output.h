// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <nlohmann/json.hpp>

#include "cli/console.h"

namespace reamsim {

/// Prints one JSON document, which is all that a command with --json writes to standard output. Bytes that are no
/// UTF-8, as names of files may have, are replaced.
void print_json(const nlohmann::ordered_json& json);

/// Calls `work` with a console that is quiet. Where it throws, prints {"program", "ok": false, "mistakes": [...]}, or
/// "error" where the input is not to blame, and throws again, so that standard error and exit status are the usual
/// ones.
void run_with_json(const Console& console, const std::function<void(const Console&)>& work);

}  // namespace reamsim
