// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>

#include "kernels/distance_grid.h"
#include "kernels/window.h"
#include "sim/engine/common/engine.h"
#include "sim/engine/common/tables.h"
#include "sim/engine/exact/brick_batch_plan.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/distance_grid.h"
#include "sim/tool/tool.h"

namespace reamsim {

using BasisValues = std::array<double, kBasisValues>;

/// The arguments of a substep with the constants to which its forces are linear, one at a time: the law itself,
/// evaluated with each of them, gives the basis.
struct UnitArgs {
  /// `edges_per_turn`: cutting edges/2π, mm of edge per mm² of face at a radius of 1 mm; 0: no edge force.
  UnitArgs(const SubstepArgs& args, float edges_per_turn);

  SubstepArgs without_normal;  ///< k_n = 0
  SubstepArgs with_normal;     ///< k_n = 1
  SubstepArgs edge_along;      ///< K_t = 1 N/mm, K_n = 0
  SubstepArgs edge_normal;     ///< K_t = 0, K_n = 1 N/mm
};

/// The basis of a voxel next to `clip` that loses a unit of fill. `volume_mm3`: of the whole voxel.
BasisValues unit_response(const UnitArgs& args, const Clip& clip, float volume_mm3);

/// The basis of cutting edges in contact with a voxel; see rs_edge_force().
BasisValues edge_response(const UnitArgs& args, const Clip& clip, rs_i32 remaining, rs_i32 outside);

/// Sums of one brick by substep and grade, added voxel by voxel.
class BrickBasis {
 public:
  explicit BrickBasis(int substeps) : substeps_(substeps) {}

  /// Adds `factor` times `values` to a grade in a substep.
  void add(int substep, int grade, double factor, const BasisValues& values);

 private:
  friend class VisitBasis;
  struct Grade {
    int grade;
    std::vector<BasisValues> sums;  ///< by substep
  };

  int substeps_;
  std::vector<Grade> grades_;
};

/// Sums over the bricks, by substep and grade. A brick's are rounded to integers once, so that these do not depend on
/// the order of the bricks.
class VisitBasis {
 public:
  explicit VisitBasis(int substeps) : sums_(static_cast<std::size_t>(substeps) * kGrades) {}

  /// From any thread.
  void add(const BrickBasis& brick);
  /// The basis of each substep.
  [[nodiscard]] std::vector<SubstepBasis> substeps() const;

 private:
  static constexpr std::size_t kGrades = 256;
  using Units = std::array<std::int64_t, kBasisValues>;

  std::mutex mutex_;
  std::vector<Units> sums_;
};

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
