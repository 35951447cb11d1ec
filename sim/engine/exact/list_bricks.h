// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/device_bricks.h"
#include "sim/engine/exact/brick_batch_plan.h"
#include "sim/tool/distance_table.h"

namespace reamsim {

/// Distances for lists of bricks. They cover every point within the reach of kernels/list_bricks.cl plus `slack_mm` of
/// the profile. Samples lie at the centres of the kernel's cells.
DistanceTable brick_distances(const Profile& profile, double voxel_mm, double slack_mm);
/// The grid of these samples, for the kernel.
CoarseGrid coarse_grid(const DistanceTable& table);

/// The bricks that the tool's surface can intersect in a visit; see kernels/list_bricks.cl.
class ListBricks {
 public:
  /// `slack_mm`: largest distance of the clipping surface from the profile.
  ListBricks(const cl::Device& device, const DeviceBricks& bone, const DeviceBatch& batch, const Profile& profile,
             double slack_mm, std::size_t work_group);

  /// Lists the bricks of a visit, and returns their number.
  std::size_t list(const BrickBatchPlan& visit, VisitCounts counts);
  /// Run time of the lists since the last call, s.
  double take_seconds() { return kernel_.take_total_s(); }

  [[nodiscard]] const cl::Buffer<cl_uint>& listed() const { return listed_; }
  [[nodiscard]] const cl::Buffer<VisitCounts>& counts() const { return counts_; }

 private:
  const cl::Device& device_;
  float slack_mm_;
  cl::Buffer<CoarseGrid> grid_;
  cl::Buffer<float> distances_;
  cl::Buffer<cl_uint> listed_;
  cl::Buffer<VisitCounts> counts_;
  cl::SlotKernel kernel_;
};

}  // namespace reamsim
