#pragma once

#include <string>

#include "sim/scenario/yaml_tree.h"

namespace reamsim {

/// Applies one `--set key.path=value` to a document and returns the changed one. Sections that are missing are made;
/// "motion.keyframes.0.time_s" reaches into a list; a value of null takes the key away. The value is read as YAML
/// ("[0, 0, 5]" is a list) and, where that fails or gives a section, as plain text.
/// Throws InputError ("--set key=value: ..."): no "=", no key, an index that the list does not have.
YamlNodePtr apply_override(const YamlNodePtr& document, const std::string& assignment);

}  // namespace reamsim
