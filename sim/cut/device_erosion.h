#pragma once

#include "sim/collide/dense_state.h"
#include "sim/collide/device_batch.h"
#include "sim/cut/energy_table.h"
#include "sim/cut/erosion.h"

namespace reamsim {

/// `remove` and `wear` on OpenCL: work-items stride over the contact list.
class DeviceErosion final : public Erosion {
 public:
  DeviceErosion(const cl::Device& device, VoxelLayout layout, const DenseState& state, const DeviceBatch& batch,
                const EnergyTable& table, std::size_t work_group);
  void cut(int slot) override;
  std::vector<double> take_seconds() override;

 private:
  const cl::Device& device_;
  std::size_t items_;
  std::size_t work_group_;
  cl::Buffer<double> energy_;
  cl::Buffer<double> density_;
  cl::Program program_;
  cl::Kernel kernel_;
  std::vector<cl::Event> events_;
};

}  // namespace reamsim
