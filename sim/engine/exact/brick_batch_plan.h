// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
#include <span>
#include <vector>

#include "kernels/bricks.h"
#include "kernels/window.h"
#include "sim/base/geometry.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/engine/common/device_batch.h"
#include "sim/engine/common/device_bricks.h"
#include "sim/engine/common/nearest_lists.h"
#include "sim/tool/distance_grid.h"

namespace reamsim {

/// The window of smooth motion of each slot; nullptr: none.
using MotionsOfSlots = std::vector<std::shared_ptr<const MotionWindow>>;

/// The substeps of a visit (`erosion: exact`), divided into windows of little motion.
struct BrickBatchPlan {
  int first = 0;                       ///< slot
  int end = 0;                         ///< past the last
  std::vector<SubstepWindow> windows;  ///< in order, without gaps
  std::vector<MotionWindow> motions;   ///< of these windows
  float shift_mm = 0;                  ///< bound of the motion of any point near the tool since `first`, T
  VoxelBox superbricks;                ///< of 4×4×4 bricks, that overlap the tool's box in any substep
};

/// Largest motion in a visit, voxels: the margin around the tool in kernels/list_bricks.cl.
inline constexpr double kVisitShiftVoxels = 16;

/// Plans a visit of at most `most` substeps from slot `first` on. `tool_box`: T, mm; `bone`: voxels with bone.
BrickBatchPlan plan_brick_batch(std::span<const SubstepArgs> args, const MotionsOfSlots& motions, int first, int most,
                                const Aabb& tool_box, const VoxelBox& bone);

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
