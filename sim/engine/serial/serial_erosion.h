#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "kernels/cut_law.h"
#include "sim/engine/common/energy_table.h"
#include "sim/engine/common/erosion.h"
#include "sim/engine/serial/serial_state.h"

namespace reamsim {

/// The fill that voxel `voxel` (VoxelGrid::index) loses in a substep; what that does to the tool goes into `law`.
using CutVoxel =
    std::function<rs_i32(const SerialState& state, const SubstepArgs& args, std::int64_t voxel, LaneSums& law)>;

/// The reference for `remove` and `wear`.
CutVoxel cut_touched(const EnergyTable& table);
/// The reference for `exact`.
CutVoxel cut_by_clipping(const EnergyTable& table);

/// Cuts every voxel of the contact list in turn.
class SerialErosion final : public Erosion {
 public:
  SerialErosion(SerialState& state, CutVoxel cut) : state_(state), cut_(std::move(cut)) {}
  void cut(int slot) override;
  std::vector<double> take_seconds() override { return std::exchange(seconds_, {}); }

 private:
  SerialState& state_;
  CutVoxel cut_;
  std::vector<double> seconds_;
};

}  // namespace reamsim
