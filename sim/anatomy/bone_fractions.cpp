// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/bone_fractions.h"

#include <cmath>

namespace reamsim {

int least_dense_grade(double dense_g_cm3) {
  // A multiple of the grade step, such as 1.0, is not exact in binary.
  constexpr double kSlack = 1e-9;
  return static_cast<int>(std::ceil(dense_g_cm3 / DensityMapping::kGradeStep_g_cm3 - kSlack));
}

BoneFractions::BoneFractions(const ReamedBone& bone, double dense_g_cm3)
    : bone_(bone),
      voxels_per_mm_(1 / bone.voxmap.grid.voxel_mm),
      bricks_(BrickLattice::over(bone.voxmap.grid.dims)),
      dense_grade_(least_dense_grade(dense_g_cm3)) {}

void BoneFractions::select_brick(const Vec3i& brick) {
  if (brick == view_.coord) return;
  view_ = {.coord = brick};
  if (!bricks_.contains(brick)) return;
  view_.grade = bone_.voxmap.grade.brick(brick);
  view_.before = bone_.fill_before.brick(brick);
  view_.after = bone_.fill_after.brick(brick);
}

void BoneFractions::add(int offset, double weight, Fractions& sum) const {
  const auto at = static_cast<std::size_t>(offset);
  const int grade = (*view_.grade)[at];
  if (grade == 0) return;
  constexpr double kWhole = FillBricks::kWhole;
  const double after = view_.after == nullptr ? weight : weight * (*view_.after)[at] / kWhole;
  sum.before += view_.before == nullptr ? weight : weight * (*view_.before)[at] / kWhole;
  sum.after += after;
  if (grade >= dense_grade_) sum.dense += after;
}

Fractions BoneFractions::at(const Vec3& point_mm) {
  const Vec3 place = (point_mm - bone_.voxmap.grid.origin_mm) * voxels_per_mm_ - Vec3::Constant(0.5);
  const Vec3 lower = place.array().floor();
  const Vec3i first = lower.cast<int>();
  const Vec3i brick = BrickLattice::brick_of(first);
  const Vec3i local = first - BrickLattice::kSide * brick;
  const bool one_brick = (local.array() < BrickLattice::kSide - 1).all();
  if (one_brick) select_brick(brick);
  Fractions sum;
  for_each_trilinear_weight(place - lower, [&](const Vec3i& step, double weight) {
    if (!one_brick) select_brick(BrickLattice::brick_of(first + step));
    if (view_.grade != nullptr) add(BrickLattice::offset_of(first + step), weight, sum);
  });
  return sum;
}

}  // namespace reamsim
