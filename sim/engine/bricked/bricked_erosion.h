#pragma once

#include "sim/engine/bricked/bricked_detector.h"
#include "sim/engine/common/energy_table.h"
#include "sim/engine/common/erosion.h"

namespace reamsim {

/// `remove` and `wear` over the list of touched bricks; see kernels/cut_bricked.cl.
class BrickedErosion final : public Erosion {
 public:
  BrickedErosion(const cl::Device& device, BrickedState& state, const DeviceBatch& batch, const EnergyTable& table,
                 const BrickedOptions& options);
  void cut(int slot) override;
  std::vector<double> take_seconds() override { return kernel_.take_seconds(); }

 private:
  std::size_t items_;
  cl::Buffer<double> energy_;
  cl::Buffer<cl_long> units_;
  cl::Buffer<double> density_;
  cl::Buffer<cl_ulong> bits_of_byte_;
  cl::SlotKernel kernel_;
};

}  // namespace reamsim
