// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/console.h"
#include "sim/study/reforce.h"

namespace reamsim {

// The statistics of `fit`, `uq`, `validate` and `sweep` are those of the Python package (python/src/reamsim/lab), in a
// process of the interpreter that REAMSIM_PYTHON names, otherwise of that of the system.

/// Throws RunError where Python or one of its packages is missing: before a command simulates what needs them.
void require_lab();

/// Calls a command of the package with its paths and a job, whose texts are UTF-8. Throws InputError and RunError as
/// the package says, and Interrupted, after the process has ended.
nlohmann::ordered_json call_lab(const std::string& command, const std::vector<std::string>& paths,
                                const nlohmann::ordered_json& job);

/// Prints what an answer says and warns of.
void say_answer(const nlohmann::ordered_json& answer, const Console& console);

/// The constants of the force law and the relation from HU to density, by their keys.
nlohmann::ordered_json law_json(const LawSettings& law);

/// Throws InputError where forces.csv of a run is missing or damaged.
void require_readable_log(const std::string& run_dir);

}  // namespace reamsim
