// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <utility>
#include <vector>

#include "sim/scenario/yaml_tree.h"

namespace reamsim {

/// Keys with their values as text: ("motion.plunge.entry_mm", "[0, 0, 1]").
using ScenarioValues = std::vector<std::pair<std::string, std::string>>;

/// Every value of a scenario that can change a number of the results, in the order of the document.
ScenarioValues values_of_scenario(const YamlNode& document);

}  // namespace reamsim
