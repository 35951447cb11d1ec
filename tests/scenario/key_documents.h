// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

// What is generated from the description of keys that the parser uses, describe_scenario().
namespace reamsim::test {

/// assets/scenario.schema.json.
std::string scenario_json_schema();

/// The table of keys for docs/keys.md (Markdown).
std::string scenario_key_table();

/// assets/study.schema.json with the keys of scenarios.
std::string study_json_schema(const std::string& schema);

}  // namespace reamsim::test
