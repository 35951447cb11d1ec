// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
#include <span>

#include "kernels/distance_grid.h"
#include "sim/engine/basis/visit_basis.h"
#include "sim/engine/common/outline_table.h"
#include "sim/engine/exact/brick_batch_plan.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/distance_grid.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// The force basis of `erosion: exact`. It cuts its own copy of the bone on the host, by the law and the windows of the
/// engine (kernels/window.h, kernels/clip.h), and so finds the same losses voxel by voxel.
class ExactBasis {
 public:
  /// `tool` and the voxmap must outlive it.
  ExactBasis(const Scenario& scenario, const BoneView& bone, const Tool& tool);

  /// Cuts through consecutive substeps. Returns the basis of each.
  std::vector<SubstepBasis> cut(std::span<const SubstepArgs> args, const MotionsOfSlots& motions);

 private:
  struct Visit;
  struct BrickVisit;
  using Page = std::array<std::uint16_t, RS_BRICK_VOXELS>;

  [[nodiscard]] std::vector<Vec3i> bricks_in_reach(const SubstepArgs& args, const BrickBatchPlan& plan) const;
  Page& page_of(const Vec3i& brick);
  void cut_brick(const Visit& visit, const Vec3i& at, VisitBasis& sums);
  /// The blocks of 4×4×4 voxels of a brick that the surface can reach while the tool moves by `shift` voxels, a bit
  /// each.
  [[nodiscard]] unsigned blocks_in_reach(const SubstepArgs& args, float shift, const BrickVisit& brick,
                                         const BrickMiddle& middle) const;
  /// Whether the surface can intersect a voxel, or contains it, meanwhile.
  [[nodiscard]] bool in_reach(const SubstepArgs& args, float shift, const BrickVisit& brick, const BrickMiddle& middle,
                              int offset) const;
  [[nodiscard]] Clip clip(const SubstepArgs& args, const BrickVisit& brick, const BrickMiddle& middle,
                          int offset) const;
  [[nodiscard]] bool cut_smoothly(const Visit& visit, const SubstepWindow& window, BrickVisit& brick, int offset) const;
  void cut_by_frames(const Visit& visit, const SubstepWindow& window, BrickVisit& brick, int offset) const;

  const Tool* tool_;
  const GradeBricks* grades_;
  FillBricks fill_before_;
  BrickLattice lattice_;
  std::vector<std::unique_ptr<Page>> pages_;  ///< fill by brick; none: that before the run
  VoxelBox extent_;
  OutlineTable outline_;
  OutlineView view_;
  Aabb tool_box_;
  DistanceTable table_;
  CoarseGrid coarse_;
  float slack_mm_;
  DistanceLattice teeth_{};
  std::array<float, 256> energy_mj_{};  ///< of a whole voxel, by grade
  float volume_mm3_;
  float edges_per_turn_;
};

}  // namespace reamsim
