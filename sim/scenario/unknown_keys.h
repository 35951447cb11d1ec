#pragma once

#include <string>

#include "sim/base/mistake_list.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

/// Puts every key of the document that key_tree() does not know on the list, with the key that was probably meant.
/// Sections that hold something else than keys are left to the reader.
void reject_unknown_keys(const YamlNode& document, const std::string& file, MistakeList& mistakes);

/// What to say of an unknown key that stands in `section`: "did you mean feed_mm_s (mm/s)?", or the keys there are.
std::string suggest_key(const KeyNode& section, const std::string& unknown);

}  // namespace reamsim
