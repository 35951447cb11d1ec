// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string_view>
#include <vector>

#include "sim/scenario/scenario.h"

namespace reamsim {

/// Sets the keys that `cutting.preset` defines, except those that the scenario gives. Sources: docs/physics.md, 4.
void apply_preset(const KeyLocations& locations, CuttingSettings& cutting);

/// Keys of the section `cutting` that differ from its preset; none without a preset.
std::vector<std::string_view> changed_from_preset(const CuttingSettings& cutting);

/// Replaces the defaults of a glenoid phantom by those of its Walch type (docs/glenoid.md has their sources). Does
/// nothing with `walch: none`.
void apply_walch_defaults(PhantomSettings& phantom);

}  // namespace reamsim
