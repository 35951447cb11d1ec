// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <cmath>

#include "sim/base/error.h"
#include "sim/bone/bone.h"
#include "sim/bone/voxmap/cube_fraction.h"

namespace reamsim {

namespace {

/// A drilled cylinder in the frame B.
struct Hole {
  Vec3 entry_mm;
  Vec3 axis;
  double radius_mm = 0;
  double depth_mm = 0;

  [[nodiscard]] bool contains(const Vec3& point_mm) const {
    const Vec3 from_entry = point_mm - entry_mm;
    const double along_mm = from_entry.dot(axis);
    if (along_mm < 0 || along_mm > depth_mm) return false;
    return (from_entry - along_mm * axis).squaredNorm() <= radius_mm * radius_mm;
  }
  /// Negative in the hole, mm.
  [[nodiscard]] double distance_mm(const Vec3& point_mm) const {
    const Vec3 from_entry = point_mm - entry_mm;
    const double along_mm = from_entry.dot(axis);
    return std::max({(from_entry - along_mm * axis).norm() - radius_mm, -along_mm, along_mm - depth_mm});
  }
  [[nodiscard]] Aabb bounds_mm() const {
    const Vec3 end_mm = entry_mm + depth_mm * axis;
    const Vec3 room = Vec3::Constant(radius_mm);
    return {entry_mm.cwiseMin(end_mm) - room, entry_mm.cwiseMax(end_mm) + room};
  }
};

Hole hole_in_bone(const PilotHoleSettings& settings, const std::optional<GlenoidFrame>& glenoid) {
  const double length = settings.axis.norm();
  if (!std::isfinite(length) || length < 1e-9) {
    throw InputError({}, "bone.pilot_hole.axis", "a vector of length 0", "give the direction of drilling");
  }
  Hole hole{settings.entry_mm, settings.axis / length, settings.diameter_mm / 2, settings.depth_mm};
  if (settings.frame != PoseFrame::glenoid) return hole;
  if (!glenoid) {
    throw InputError({}, "bone.pilot_hole.frame", "frame is glenoid but bone.glenoid is missing",
                     "add bone.glenoid, or use frame: bone");
  }
  hole.entry_mm = glenoid->bone_from_glenoid * hole.entry_mm;
  hole.axis = glenoid->bone_from_glenoid.linear() * hole.axis;
  return hole;
}

/// The remaining fill of a whole voxel.
std::uint16_t fill_beside(const Hole& hole, const VoxelGrid& grid, const Vec3i& voxel, bool partial) {
  const Vec3 center_mm = grid.center_mm(voxel);
  if (!partial) return hole.contains(center_mm) ? 0 : FillBricks::kWhole;
  const double away_voxels = hole.distance_mm(center_mm) / grid.voxel_mm;
  if (std::abs(away_voxels) > RS_CLIP_REACH) return away_voxels < 0 ? 0 : FillBricks::kWhole;
  const auto distance = [&hole](const Vec3& point_mm) { return hole.distance_mm(point_mm); };
  const double fraction = 1 - fraction_inside(distance, center_mm, grid.voxel_mm);
  return static_cast<std::uint16_t>(std::lround(fraction * FillBricks::kWhole));
}

/// Limits the fill of a voxel to `most`; returns the removed fill.
int limit_fill(FilledVoxmap& voxmap, const Vec3i& voxel, std::uint16_t most) {
  const int before = voxmap.fill.get(voxel);
  if (before <= most) return 0;
  if (most == 0) {
    voxmap.grade.set(voxel, 0);
  } else {
    voxmap.fill.set(voxel, most);
  }
  return before - most;
}

}  // namespace

double drill_pilot_hole(FilledVoxmap& voxmap, const PilotHoleSettings& settings,
                        const std::optional<GlenoidFrame>& glenoid, bool partial) {
  const Hole hole = hole_in_bone(settings, glenoid);
  const VoxelGrid& grid = voxmap.grid;
  const Aabb box = hole.bounds_mm();
  // Clamped as doubles, because a distant entry would overflow an int.
  const Eigen::Array3d most = grid.dims.cast<double>().array() - 1;
  const Eigen::Array3d low = ((box.min - grid.origin_mm) / grid.voxel_mm).array().floor().max(0).min(most);
  const Eigen::Array3d high = ((box.max - grid.origin_mm) / grid.voxel_mm).array().floor().max(0).min(most);
  std::int64_t drilled = 0;
  for_each_voxel(low.cast<int>().matrix(), high.cast<int>().matrix(), [&](const Vec3i& voxel) {
    if (voxmap.grade.get(voxel) == 0) return;
    drilled += limit_fill(voxmap, voxel, fill_beside(hole, grid, voxel, partial));
  });
  return static_cast<double>(drilled) / FillBricks::kWhole * grid.voxel_mm3();
}

}  // namespace reamsim
