// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/column_bone.h"

#include <algorithm>
#include <cmath>

namespace reamsim {

namespace {

constexpr double kStepsPerVoxel = 2;
/// Interpolation spreads a surface over a voxel above it.
constexpr double kAboveVoxels = 1.5;
/// Smaller fractions come from interpolation and rounding.
constexpr double kNothing = 0.02;
constexpr double kHalfCover = 0.5;

}  // namespace

ColumnBone::ColumnBone(const ReamedBone& bone, const ColumnMap& map, double dense_g_cm3)
    : map_(map), fractions_(bone, dense_g_cm3), voxel_mm_(bone.voxmap.grid.voxel_mm) {}

template <class Visit>
void ColumnBone::descend(const ColumnPlace& place, double top_mm, double bottom_mm, const Visit& visit) {
  const double first_mm = top_mm + kAboveVoxels * voxel_mm_;
  const double length_mm = first_mm - bottom_mm;
  if (length_mm <= 0) return;
  const double steps = std::ceil(length_mm * kStepsPerVoxel / voxel_mm_);
  const double step_mm = length_mm / steps;
  for (double i = 0.5; i < steps; ++i) {
    const double z_mm = first_mm - i * step_mm;
    if (!visit(fractions_.at(map_.in_bone(place, z_mm)), step_mm, top_mm - z_mm)) return;
  }
}

ColumnBone::Length ColumnBone::layer(const ColumnPlace& place, double top_mm, double depth_mm) {
  Length out;
  descend(place, top_mm, top_mm - depth_mm, [&](const Fractions& here, double step_mm, double /*below_mm*/) {
    out.bone_mm += here.after * step_mm;
    out.dense_mm += here.dense * step_mm;
    return true;
  });
  return out;
}

double ColumnBone::largest_fraction(const ColumnPlace& place, double top_mm, double bottom_mm) {
  double largest = 0;
  descend(place, top_mm, bottom_mm, [&](const Fractions& here, double /*step_mm*/, double /*below_mm*/) {
    largest = std::max(largest, here.after);
    return true;
  });
  return largest;
}

double ColumnBone::continuous_mm(const ColumnPlace& place, double top_mm, double bottom_mm, double cover,
                                 double Fractions::*state) {
  const double half = kHalfCover * cover;
  double length_mm = 0;
  bool inside = false;
  descend(place, top_mm, bottom_mm, [&](const Fractions& here, double step_mm, double below_mm) {
    const double fraction = here.*state;
    inside |= fraction >= half;
    if (!inside && fraction < kNothing) length_mm = 0;  // bone above a gap
    if (!inside && below_mm > kAboveVoxels * voxel_mm_) return false;
    if (inside && fraction < kNothing) return false;
    length_mm += fraction * step_mm;
    return true;
  });
  return inside ? length_mm : 0;
}

}  // namespace reamsim
