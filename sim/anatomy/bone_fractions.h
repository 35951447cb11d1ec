// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// A bone before and after reaming, on one lattice and with one set of grades.
struct ReamedBone {
  const Voxmap& voxmap;
  const FillBricks& fill_before;
  const FillBricks& fill_after;
};

/// The fractions of bone at a point, 0…1.
struct Fractions {
  double before = 0;
  double after = 0;
  double dense = 0;  ///< bone after reaming whose density is at least the threshold
};

/// The fractions of bone between the centres of the voxels: trilinear, air outside the lattice. Integrated along a line
/// they conserve the volume of bone, so that a surface of partly filled voxels is located to a small part of a voxel.
/// Not thread-safe: it caches the last brick.
class BoneFractions {
 public:
  /// `dense_g_cm3`: the least density of dense bone.
  BoneFractions(const ReamedBone& bone, double dense_g_cm3);

  /// At a point of B.
  [[nodiscard]] Fractions at(const Vec3& point_mm);

 private:
  struct BrickView {
    Vec3i coord = Vec3i::Constant(-1);
    const GradeBricks::Brick* grade = nullptr;  ///< null: air
    const FillBricks::Brick* before = nullptr;  ///< null: whole
    const FillBricks::Brick* after = nullptr;
  };

  void select_brick(const Vec3i& brick);
  void add(int offset, double weight, Fractions& sum) const;

  const ReamedBone bone_;
  double voxels_per_mm_;
  BrickLattice bricks_;
  int dense_grade_;
  BrickView view_;
};

/// The least grade whose density is at least `dense_g_cm3`.
int least_dense_grade(double dense_g_cm3);

}  // namespace reamsim
