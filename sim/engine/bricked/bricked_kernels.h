// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/engine/bricked/bricked_state.h"
#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/kernel_options.h"

namespace reamsim {

/// A stage of `bricked` with its arguments and its number of work-items.
struct BrickedStage {
  cl::SlotKernel kernel;
  std::size_t items;

  void enqueue(int slot) { kernel.run(slot, items); }
};

/// Cells of shell points against bricks of voxels; see kernels/detect_bricked.cl.
BrickedStage make_detect_bricked(const cl::Device& device, const BrickedState& state, const DeviceBatch& batch,
                                 const KernelOptions& options);

/// `remove` and `wear` over the list of touched bricks; see kernels/cut_bricked.cl.
BrickedStage make_cut_bricked(const cl::Device& device, const BrickedState& state, const DeviceBatch& batch,
                              const KernelOptions& options);

}  // namespace reamsim
