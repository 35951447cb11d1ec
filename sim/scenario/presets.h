#pragma once

#include <string_view>
#include <vector>

#include "sim/scenario/reader.h"

namespace reamsim {

/// Fills in what `cutting.preset` stands for, except in keys that the scenario gives itself. Without a preset nothing
/// changes. Sources: docs/physics.md, section 4.
void apply_preset(const KeyLocations& locations, CuttingSettings& cutting);

/// Keys of the section `cutting` that say otherwise than its preset; none without a preset.
std::vector<std::string_view> changed_from_preset(const CuttingSettings& cutting);

}  // namespace reamsim
