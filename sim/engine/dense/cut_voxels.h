#pragma once

#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/energy_table.h"
#include "sim/engine/dense/dense_state.h"

namespace reamsim {

/// `remove` and `wear` on OpenCL: work-items stride over the contact list.
class CutVoxels {
 public:
  CutVoxels(const cl::Device& device, VoxelLayout layout, const DenseState& state, const DeviceBatch& batch,
            const EnergyTable& table, std::size_t work_group);
  void enqueue(int slot);
  std::vector<double> take_seconds() { return kernel_.take_seconds(); }

 private:
  /// The parameters of the kernel, in its order.
  enum class Argument : cl_uint {
    args,
    substep,
    bone,
    fill,
    has_fill,
    claims,
    contacts,
    contact_count,
    sums,
    removed,
    removed_count,
    energy_of_grade,
    density_of_grade,
    edges,
    numbers,
    lists,
    grid,
    hu_of_air,
    hu_per_grade
  };

  std::size_t items_;
  cl::Buffer<double> energy_;
  cl::Buffer<double> density_;
  cl::SlotKernel kernel_;
};

}  // namespace reamsim
