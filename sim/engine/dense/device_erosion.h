#pragma once

#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/energy_table.h"
#include "sim/engine/common/erosion.h"
#include "sim/engine/dense/dense_state.h"

namespace reamsim {

/// `remove` and `wear` on OpenCL: work-items stride over the contact list.
class DeviceErosion final : public Erosion {
 public:
  DeviceErosion(const cl::Device& device, VoxelLayout layout, const DenseState& state, const DeviceBatch& batch,
                const EnergyTable& table, std::size_t work_group);
  void cut(int slot) override;
  std::vector<double> take_seconds() override { return kernel_.take_seconds(); }

 private:
  std::size_t items_;
  cl::Buffer<double> energy_;
  cl::Buffer<double> density_;
  cl::SlotKernel kernel_;
};

}  // namespace reamsim
