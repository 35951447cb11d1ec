#pragma once

#include "sim/engine/bricked/bricked_state.h"
#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/kernel_options.h"

namespace reamsim {

/// Cells of shell points against bricks of voxels; see kernels/detect_bricked.cl.
class DetectBricked {
 public:
  DetectBricked(const cl::Device& device, const BrickedState& state, const DeviceBatch& batch,
                const KernelOptions& options);
  void enqueue(int slot);
  std::vector<double> take_seconds() { return kernel_.take_seconds(); }

 private:
  /// The parameters of the kernel, in its order.
  enum class Argument : cl_uint {
    args,
    substep,
    cells,
    cell_count,
    runs,
    run_cells,
    offsets,
    slot_of_brick,
    occupancy,
    listed,
    touched_list,
    touched_count,
    sums,
    bricks,
    culling,
    room,
    removed_count,
    removed_before,
    edges,
    numbers,
    lists,
    grid,
    pool_0
  };

  std::size_t items_;
  cl::SlotKernel kernel_;
};

}  // namespace reamsim
