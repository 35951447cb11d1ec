#include <cmath>

#include "sim/base/error.h"
#include "sim/bone/bone.h"

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
  [[nodiscard]] Aabb bounds_mm() const {
    const Vec3 end_mm = entry_mm + depth_mm * axis;
    const Vec3 room = Vec3::Constant(radius_mm);
    return {entry_mm.cwiseMin(end_mm) - room, entry_mm.cwiseMax(end_mm) + room};
  }
};

Hole hole_in_bone(const PilotHoleSettings& settings, const std::optional<GlenoidFrame>& glenoid) {
  const double length = settings.axis.norm();
  if (!std::isfinite(length) || length < 1e-9) {
    throw InputError({}, "bone.pilot_hole.axis", "a vector without length", "expected the way the drill goes in");
  }
  Hole hole{settings.entry_mm, settings.axis / length, settings.diameter_mm / 2, settings.depth_mm};
  if (settings.frame != "glenoid") return hole;
  if (!glenoid) {
    throw InputError({}, "bone.pilot_hole.frame", "\"glenoid\" for a bone without a glenoid frame",
                     "expected bone.glenoid, or the frame bone");
  }
  hole.entry_mm = glenoid->bone_from_glenoid * hole.entry_mm;
  hole.axis = glenoid->bone_from_glenoid.linear() * hole.axis;
  return hole;
}

}  // namespace

double drill_pilot_hole(Voxmap& voxmap, const PilotHoleSettings& settings, const std::optional<GlenoidFrame>& glenoid) {
  const Hole hole = hole_in_bone(settings, glenoid);
  const VoxelGrid& grid = voxmap.grid;
  const Aabb box = hole.bounds_mm();
  // Clamped as doubles first: an entry far away must not overflow.
  const Eigen::Array3d most = grid.dims.cast<double>().array() - 1;
  const Eigen::Array3d low = ((box.min - grid.origin_mm) / grid.voxel_mm).array().floor().max(0).min(most);
  const Eigen::Array3d high = ((box.max - grid.origin_mm) / grid.voxel_mm).array().floor().max(0).min(most);
  const Vec3i first = low.cast<int>().matrix();
  const Vec3i last = high.cast<int>().matrix();
  std::int64_t drilled = 0;
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        if (voxmap.grade.get({x, y, z}) == 0 || !hole.contains(grid.center_mm(x, y, z))) continue;
        voxmap.grade.set({x, y, z}, 0);
        drilled += voxmap.fill.get({x, y, z});
      }
    }
  }
  return static_cast<double>(drilled) / FillBricks::kWhole * grid.voxel_mm3();
}

}  // namespace reamsim
