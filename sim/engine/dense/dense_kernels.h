// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>

#include "sim/engine/common/device_batch.h"
#include "sim/engine/dense/dense_state.h"

namespace reamsim {

/// A stage over a dense voxmap with its arguments.
struct DenseStage {
  cl::SlotKernel kernel;
  /// Sets the arguments that a substep changes, beside its slot, and returns the number of work-items.
  std::function<std::size_t(const SubstepArgs&, cl::SlotKernel&)> prepare;

  void enqueue(int slot, const SubstepArgs& args) { kernel.run(slot, prepare(args, kernel)); }
};

/// The narrow phase: writes the voxels that the tool touches in a substep to the contact list, each once, and changes
/// nothing that the cut writes. `work_group` is the size of a group; results do not depend on it.
///
/// `direct` is the paper's (§3.5): one work-item per shell point, a Morton code. `octree` is that of Zheng et al. as
/// Faieghi et al. (2020, §4.3.1) rebuilt it: one work-item per shell point, three floats, that descends the grid
/// through look-up tables. `implicit` is that of Yau et al., rebuilt likewise (§4.3.2): one work-item per voxel of the
/// VOI against the tool's solid of revolution.
DenseStage make_detect_kernel(const cl::Device& device, const Scenario& scenario, const DenseState& state,
                              const DeviceBatch& batch, const BoneView& bone, const Tool& tool, std::size_t work_group);

/// The cut for `remove` and `wear`: work-items stride over the contact list.
DenseStage make_cut_kernel(const cl::Device& device, const DensePlan& plan, const DenseState& state,
                           const DeviceBatch& batch, std::size_t work_group);

}  // namespace reamsim
