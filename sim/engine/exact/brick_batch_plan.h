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
#include "sim/engine/common/tables.h"
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

}  // namespace reamsim
