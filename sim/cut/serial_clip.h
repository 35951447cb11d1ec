#pragma once

#include <utility>

#include "sim/base/stopwatch.h"
#include "sim/collide/serial_state.h"
#include "sim/cut/energy_table.h"
#include "sim/cut/erosion.h"

namespace reamsim {

/// The reference for `exact`: every voxel of the contact list is clipped in turn.
class SerialClip final : public Erosion {
 public:
  SerialClip(SerialState& state, const EnergyTable& table) : state_(state), table_(table) {}
  void cut(int slot) override;
  std::vector<double> take_seconds() override { return std::exchange(seconds_, {}); }

 private:
  SerialState& state_;
  EnergyTable table_;
  std::vector<double> seconds_;
};

}  // namespace reamsim
