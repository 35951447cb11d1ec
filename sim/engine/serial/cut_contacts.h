#pragma once

#include <functional>

#include "kernels/cut_law.h"
#include "sim/engine/common/energy_table.h"
#include "sim/engine/serial/serial_state.h"

namespace reamsim {

/// The fill that voxel `voxel` (VoxelGrid::index) loses in a substep; what that does to the tool goes into `law`.
using CutVoxel =
    std::function<rs_i32(const SerialState& state, const SubstepArgs& args, std::int64_t voxel, LaneSums& law)>;

/// The reference for `remove` and `wear`.
CutVoxel cut_touched(const EnergyTable& table);
/// The reference for `exact`.
CutVoxel cut_by_clipping(const EnergyTable& table);

/// Cuts every voxel of the contact list in turn, adds to `sums`, and empties the list.
void cut_contacts(SerialState& state, const SubstepArgs& args, const CutVoxel& cut, SubstepSums& sums);

}  // namespace reamsim
