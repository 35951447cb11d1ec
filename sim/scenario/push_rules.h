// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/scenario/scenario.h"

namespace reamsim {

/// Throws InputError unless a frame of motion.push at its fastest feed is one substep (engine.max_step_voxels), so that
/// the balance of the frame is that of its cut. `scenario` has the edge length of the voxels, which a VDB tells.
void check_push_step(const Scenario& scenario, const KeyLocations& locations);

}  // namespace reamsim
