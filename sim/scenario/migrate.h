#pragma once

#include <string>
#include <vector>

#include "sim/scenario/yaml_tree.h"

namespace reamsim {

/// Brings a scenario of format version 1, or one with keys of version 1, to version 2: renames keys and drops those
/// that have no effect any more. Adds a note for each such key ("FILE:LINE:COLUMN: KEY: ..."). Throws InputError where
/// a key is given under both names.
YamlNodePtr migrate(const YamlNodePtr& document, const std::string& file, std::vector<std::string>& notes);

}  // namespace reamsim
