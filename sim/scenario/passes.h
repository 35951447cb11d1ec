// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// A tool and its motion. A scenario without `motion.passes` has one pass.
struct PassSpec {
  ToolSettings tool;
  MotionSettings motion;   ///< without passes
  std::string tool_key;    ///< of the section that `tool` is from
  std::string motion_key;  ///< of the section of the motion: motion, or motion.passes.N
};

std::vector<PassSpec> passes_of(const Scenario& scenario);

/// A mistake in a scenario of this pass alone, with the keys of the whole scenario: motion.plunge.axis is
/// motion.passes.1.plunge.axis.
InputError in_pass(const PassSpec& pass, const InputError& error);

}  // namespace reamsim
