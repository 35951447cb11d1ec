// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <mutex>

#include "sim/engine/basis/unit_response.h"

namespace reamsim {

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
