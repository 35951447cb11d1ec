// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

// What follows from the keys of a scenario: values of presets, and the passes of its motion.

/// Sets the keys that `cutting.preset` defines, except those that the scenario gives. Sources: docs/physics.md, 4.
void apply_preset(const KeyLocations& locations, CuttingSettings& cutting);

/// Keys of the section `cutting` that differ from its preset; none without a preset.
std::vector<std::string_view> changed_from_preset(const CuttingSettings& cutting);

/// Replaces the defaults of a glenoid phantom by those of its Walch type. Sources: docs/glenoid.md.
void apply_walch_defaults(PhantomSettings& phantom);

/// A tool and its motion. A scenario without `motion.passes` has one pass.
struct PassSpec {
  ToolSettings tool;
  MotionSettings motion;   ///< without passes
  std::string tool_key;    ///< of the section that `tool` is from
  std::string motion_key;  ///< of the section of the motion: motion, or motion.passes.N
};

std::vector<PassSpec> passes_of(const Scenario& scenario);

/// A mistake of this pass with the keys of the whole scenario: motion.plunge.axis is motion.passes.1.plunge.axis.
InputError in_pass(const PassSpec& pass, const InputError& error);

}  // namespace reamsim
