// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/bone_probe.h"

namespace reamsim {

double BoneProbe::fraction_of(const Vec3i& voxel) const {
  const Voxmap& voxmap = bone_.voxmap;
  if (!voxmap.grid.contains(voxel) || voxmap.grade.get(voxel) == 0) return 0;
  return static_cast<double>(bone_.fill.get(voxel)) / FillBricks::kWhole;
}

double BoneProbe::fraction(const Vec3& point_mm) const {
  const VoxelGrid& grid = bone_.voxmap.grid;
  const Vec3 place = (point_mm - grid.origin_mm) / grid.voxel_mm - Vec3::Constant(0.5);
  const Vec3 base = place.array().floor();
  double out = 0;
  for_each_trilinear_weight(
      place - base, [&](const Vec3i& step, double weight) { out += weight * fraction_of(base.cast<int>() + step); });
  return out;
}

std::optional<double> BoneProbe::crossing(const Vec3& from_mm, const Vec3& direction, double most_mm,
                                          bool into_bone) const {
  const double step_mm = 0.5 * voxel_mm();
  double before = fraction(from_mm) - 0.5;
  if ((before >= 0) == into_bone) return std::nullopt;
  for (double at_mm = step_mm; at_mm <= most_mm + step_mm; at_mm += step_mm) {
    const double here = fraction(from_mm + at_mm * direction) - 0.5;
    if ((here >= 0) == into_bone) return at_mm - step_mm * here / (here - before);
    before = here;
  }
  return std::nullopt;
}

std::optional<double> BoneProbe::distance_to_bone(const Vec3& from_mm, const Vec3& direction, double most_mm) const {
  return crossing(from_mm, direction, most_mm, true);
}

std::optional<double> BoneProbe::distance_to_air(const Vec3& from_mm, const Vec3& direction, double most_mm) const {
  return crossing(from_mm, direction, most_mm, false);
}

}  // namespace reamsim
