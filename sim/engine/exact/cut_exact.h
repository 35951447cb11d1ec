// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/engine/common/energy_table.h"
#include "sim/engine/common/kernel_options.h"
#include "sim/engine/common/outline_table.h"
#include "sim/engine/common/teeth_table.h"
#include "sim/engine/exact/fill_pages.h"
#include "sim/engine/exact/list_bricks.h"

namespace reamsim {

/// `exact` over the bricks in reach; see kernels/cut_exact.cl.
class CutExact {
 public:
  /// `teeth`: the surface that clips instead of the profile; nullptr for the envelope.
  CutExact(const cl::Device& device, const DeviceBricks& bone, const DeviceBatch& batch, const ListBricks& list,
           const OutlineTable& outline, const EnergyTable& table, const KernelOptions& options,
           const DeviceTeeth* teeth);

  /// The largest number of records of removed voxels in a visit.
  [[nodiscard]] static std::size_t max_records(std::size_t listed, int substeps);
  /// Enqueues a visit of the listed bricks. `fill` needs room for a page per brick, `removed` for every record.
  void enqueue(const BrickBatchPlan& plan, const FillPages& fill, const cl::Buffer<RemovedBlock>& removed);
  /// Run time of the visits since the last call, s.
  double take_seconds() { return kernel_.take_total_s(); }

 private:
  const cl::Device& device_;
  std::size_t items_;
  cl::Buffer<float> energy_;
  cl::Buffer<SubstepWindow> windows_;
  cl::Buffer<MotionWindow> motions_;
  DeviceOutline outline_;
  cl::SlotKernel kernel_;
};

}  // namespace reamsim
