#pragma once

#include "sim/engine/bricked/detect_bricked.h"
#include "sim/engine/common/energy_table.h"

namespace reamsim {

/// `remove` and `wear` over the list of touched bricks; see kernels/cut_bricked.cl.
class CutBricked {
 public:
  CutBricked(const cl::Device& device, const BrickedState& state, const DeviceBatch& batch, const EnergyTable& table,
             const KernelOptions& options);
  void enqueue(int slot);
  std::vector<double> take_seconds() { return kernel_.take_seconds(); }

 private:
  /// The parameters of the kernel, in its order.
  enum class Argument : cl_uint {
    args,
    substep,
    lattice_of_slot,
    listed,
    occupancy,
    touched_list,
    touched_count,
    sums,
    removed,
    removed_count,
    room,
    removed_before,
    energy_of_grade,
    units_of_grade,
    density_of_grade,
    bits_of_byte,
    bricks,
    edges,
    numbers,
    lists,
    grid,
    pool_0
  };

  std::size_t items_;
  cl::Buffer<double> energy_;
  cl::Buffer<cl_long> units_;
  cl::Buffer<double> density_;
  cl::Buffer<cl_ulong> bits_of_byte_;
  cl::SlotKernel kernel_;
};

}  // namespace reamsim
