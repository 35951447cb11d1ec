// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <mutex>

#include "kernels/window.h"
#include "sim/engine/common/engine.h"

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

}  // namespace reamsim
