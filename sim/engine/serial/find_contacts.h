#pragma once

#include <functional>

#include "sim/engine/serial/serial_state.h"

namespace reamsim {

/// Appends to `state.contacts` the voxels that the tool touches in a substep, each once. Forces of points (`law:
/// per_point`) are added to `sums`.
using FindContacts = std::function<void(SerialState& state, const SubstepArgs& args, SubstepSums& sums)>;

/// The references, in plain C++: the voxels that hold a shell point. No culling, so that it also checks the VOI.
FindContacts find_by_points(const SerialState& state);
/// Of `implicit`: every voxel in turn against the tool's solid of revolution. No culling either.
void find_by_profile(SerialState& state, const SubstepArgs& args, SubstepSums& sums);
/// Of `exact`, which clips what it is given: every voxel of bone in the tool's box.
void find_in_tool_box(SerialState& state, const SubstepArgs& args, SubstepSums& sums);

}  // namespace reamsim
