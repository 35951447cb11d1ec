// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/under_face.h"

#include <algorithm>
#include <cmath>

#include "sim/base/statistics.h"

namespace reamsim {

namespace {

constexpr double kStepVoxels = 0.5;
constexpr double kFaceBandVoxels = 1.5;  // uncertainty of the face
constexpr double kHalfFraction = 0.5;
constexpr double kNoBone = 1e-6;
constexpr double kStepDownVoxels = 1;  // uncertainty of heights beside a wall

/// Length of dense bone below `face`, mm: the integral of its fraction, which includes partly filled voxels.
double dense_length(BoneFractions& fractions, const Vec3& face, const Vec3& inward, double voxel_mm, double most_mm) {
  const double step_mm = kStepVoxels * voxel_mm;
  const double band_mm = kFaceBandVoxels * voxel_mm;
  double length_mm = 0;
  bool inside = false;
  for (double along_mm = -band_mm; along_mm < most_mm; along_mm += step_mm) {
    const double fraction = fractions.at(face + along_mm * inward).dense;
    inside |= fraction >= kHalfFraction;
    if (!inside && along_mm > band_mm) return 0;
    if (!inside && fraction < kNoBone) length_mm = 0;
    length_mm += fraction * step_mm;
    if (inside && fraction < kHalfFraction) {
      // Beyond the lower end, interpolation spreads the fraction over two voxels.
      for (double tail_mm = along_mm + step_mm; tail_mm < along_mm + 2 * voxel_mm; tail_mm += step_mm) {
        const double rest = fractions.at(face + tail_mm * inward).dense;
        if (rest >= kHalfFraction || rest < kNoBone) break;
        length_mm += rest * step_mm;
      }
      return length_mm;
    }
  }
  return inside ? length_mm : 0;
}

/// Whether the bone ends within `reach` columns of one that was reamed through: in air, or at a step down to unreamed
/// bone whose surface lies below all bone that the column lost.
bool is_at_edge(const ColumnMap& map, const ColumnPlace& place, int reach, double voxel_mm) {
  const double limit_mm = map.at(place).after_mm - kStepDownVoxels * voxel_mm;
  return any_nearby(map, place, reach, [&](const ColumnPlace& other) {
    const Column& beside = map.at(other);
    return beside.state == ColumnState::air || (beside.state == ColumnState::bone && beside.before_mm < limit_mm);
  });
}

}  // namespace

std::optional<RemainingDenseBone> remaining_dense_bone(const ReamedBone& bone, const ColumnMap& map,
                                                       const ReamedFace& face, double dense_g_cm3) {
  if (!face.plane) return std::nullopt;
  const VoxelGrid& grid = bone.voxmap.grid;
  const double most_mm = grid.voxel_mm * grid.dims.cast<double>().norm();
  BoneFractions fractions(bone, dense_g_cm3);
  std::vector<double> lengths;
  lengths.reserve(face.columns.size());
  for (const ColumnPlace& place : face.columns) {
    const Vec3 point = map.in_bone(place, map.at(place).after_mm);
    lengths.push_back(dense_length(fractions, point, face.inward(point), grid.voxel_mm, most_mm));
  }
  const auto bare = std::count(lengths.begin(), lengths.end(), 0.0);
  return RemainingDenseBone{.mean_mm = mean(lengths),
                            .least_mm = *std::min_element(lengths.begin(), lengths.end()),
                            .p05_mm = quantile(lengths, 0.05),
                            .exposed_percent = 100 * static_cast<double>(bare) / static_cast<double>(lengths.size())};
}

Perforation find_perforation(const ColumnMap& map, double voxel_mm) {
  const int edge = face_edge_columns(map, voxel_mm);
  Perforation out;
  for (const ColumnGroup& group : group_columns(map, ColumnState::through)) {
    const double area_mm2 = static_cast<double>(group.columns.size()) * map.pitch_mm * map.pitch_mm;
    const bool rim = group.reaches_air ||
                     std::any_of(group.columns.begin(), group.columns.end(),
                                 [&](const ColumnPlace& place) { return is_at_edge(map, place, edge, voxel_mm); });
    if (rim) {
      out.rim_area_mm2 += area_mm2;
    } else {
      out.area_mm2 += area_mm2;
      ++out.holes;
    }
  }
  return out;
}

}  // namespace reamsim
