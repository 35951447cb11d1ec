// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/bone.h"

#include <cmath>
#include <utility>

#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/bone/voxmap/sample_voxels.h"

namespace reamsim {

namespace {

/// Copies to a brick of the shifted lattice. Its voxel (0,0,0) is voxel `shift` of `from`.
void copy_brick(const Voxmap& from, const Vec3i& shift, const Vec3i& brick_coord, GradeBricks::Brick& out) {
  const Vec3i first = GradeBricks::kSide * brick_coord + shift;
  const Vec3i last = first + Vec3i::Constant(GradeBricks::kSide - 1);
  bool any_stored = false;
  for_each_voxel(BrickLattice::brick_of(first), BrickLattice::brick_of(last), [&](const Vec3i& brick) {
    any_stored = any_stored || (from.grade.lattice().contains(brick) && from.grade.brick(brick) != nullptr);
  });
  if (!any_stored) return;
  for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
    const Vec3i voxel = BrickLattice::voxel_at(brick_coord, offset) + shift;
    if (!from.grid.contains(voxel)) continue;
    out[static_cast<std::size_t>(offset)] = from.grade.get(voxel);
  }
}

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
  Hole hole{settings.entry_mm, settings.axis / settings.axis.norm(), settings.diameter_mm / 2, settings.depth_mm};
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

constexpr double kMinSine = 0.01;  // directions closer than about half a degree do not determine the third axis

Vec3 unit(const Vec3& v, const std::string& key) {
  const double length = v.norm();
  if (!std::isfinite(length) || length < 1e-9)
    throw InputError({}, key, "a vector of length 0", "expected a direction");
  return v / length;
}

/// +z along `normal`, +y the part of `superior` perpendicular to it.
GlenoidFrame make_frame(const Vec3& center_mm, const Vec3& normal, const Vec3& superior, const std::string& key) {
  const Vec3 across = superior - superior.dot(normal) * normal;
  if (across.norm() < kMinSine) {
    throw InputError({}, key, "parallel to the normal", "expected a direction across the glenoid's face");
  }
  const Vec3 y = across.normalized();
  GlenoidFrame out;
  out.bone_from_glenoid.linear() << y.cross(normal), y, normal;
  out.bone_from_glenoid.translation() = center_mm;
  return out;
}

GlenoidFrame frame_from_landmarks(const LandmarkSettings& marks) {
  const std::string key = "bone.glenoid.landmarks";
  const Vec3 lateral = unit(marks.glenoid_center_mm - marks.trigonum_spinae_mm, key + ".trigonum_spinae_mm");
  const Vec3 superior = unit(marks.glenoid_center_mm - marks.inferior_angle_mm, key + ".inferior_angle_mm");
  const Vec3 across = superior - superior.dot(lateral) * lateral;
  if (across.norm() < kMinSine)
    throw InputError({}, key, "three points on a line", "expected a triangle: the scapular plane");
  return make_frame(marks.glenoid_center_mm, lateral, superior, key);
}

}  // namespace

void Bone::set_voxels(FilledVoxmap&& voxels) {
  fill = fill_before = std::move(voxels.fill);
  voxmap = std::make_shared<Voxmap>(std::move(static_cast<Voxmap&>(voxels)));
}

FilledVoxmap Bone::copy_voxels() const {
  FilledVoxmap out;
  static_cast<Voxmap&>(out) = *voxmap;
  out.fill = fill;
  return out;
}

FilledVoxmap fit_to_bone(const BoneView& bone, int margin_voxels) {
  const Voxmap& voxmap = bone.voxmap;
  const VoxelBox extent = bone_extent(voxmap);
  if (extent.empty()) {
    throw InputError({}, "bone", "the volume contains no bone", "expected at least one voxel of bone");
  }
  const Vec3i shift = extent.first - Vec3i::Constant(margin_voxels);
  const Vec3i needed = extent.last - extent.first + Vec3i::Constant(1 + 2 * margin_voxels);
  const Vec3i dims = (needed.array() + (FillBricks::kSide - 1)) / FillBricks::kSide * FillBricks::kSide;
  const double most_voxels = 2.0 * GradeBricks::kVoxels * static_cast<double>(voxmap.grade.stored_bricks());
  const Eigen::Array3d size = dims.cast<double>().array();
  check_lattice("bone", size, voxmap.grid.voxel_mm, {.bone_fraction = most_voxels / size.prod()});

  const VoxelGrid& from = voxmap.grid;
  FilledVoxmap out;
  out.grid = {dims, from.voxel_mm, from.origin_mm + from.voxel_mm * shift.cast<double>()};
  out.grade = sample_bricks(dims, [&](const Vec3i& brick_coord, GradeBricks::Brick& brick) {
    copy_brick(voxmap, shift, brick_coord, brick);
  });
  out.fill = FillBricks(dims);
  bone.fill.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& fill) {
    for (int offset = 0; offset < FillBricks::kVoxels; ++offset) {
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      if (extent.contains(voxel)) out.fill.set(voxel - shift, fill[static_cast<std::size_t>(offset)]);
    }
  });
  out.mapping = voxmap.mapping;
  out.layers = voxmap.layers;
  out.frame = voxmap.frame;
  return out;
}

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
    const std::uint16_t most_fill = fill_beside(hole, grid, voxel, partial);
    const int before = voxmap.fill.get(voxel);
    if (before <= most_fill) return;
    drilled += before - most_fill;
    if (most_fill == 0) {
      voxmap.grade.set(voxel, 0);
    } else {
      voxmap.fill.set(voxel, most_fill);
    }
  });
  return static_cast<double>(drilled) / FillBricks::kWhole * grid.voxel_mm3();
}

ScapularAxes axes_of(const GlenoidFrame& glenoid, BodySide side) {
  const Mat3 axes = glenoid.bone_from_glenoid.linear();
  return {.lateral = axes.col(2),
          .superior = axes.col(1),
          .anterior = side == BodySide::right ? Vec3(axes.col(0)) : Vec3(-axes.col(0))};
}

std::optional<GlenoidFrame> glenoid_frame(const GlenoidSettings& settings, BodySide side) {
  if (settings.near_mm) return std::nullopt;
  const bool any = settings.center_mm || settings.normal || settings.superior;
  if (!any && !settings.landmarks) return std::nullopt;
  if (side == BodySide::unknown) throw InputError({}, "bone.side", "missing", "a glenoid frame needs left or right");
  if (settings.landmarks) {
    if (any) throw InputError({}, "bone.glenoid", "directions and landmarks", "expected one of them");
    return frame_from_landmarks(*settings.landmarks);
  }
  if (!settings.center_mm)
    throw InputError({}, "bone.glenoid.center_mm", "missing", "expected the glenoid's centre in mm");
  if (!settings.normal)
    throw InputError({}, "bone.glenoid.normal", "missing", "expected the direction out of the face");
  if (!settings.superior) throw InputError({}, "bone.glenoid.superior", "missing", "expected the superior direction");
  return make_frame(*settings.center_mm, unit(*settings.normal, "bone.glenoid.normal"),
                    unit(*settings.superior, "bone.glenoid.superior"), "bone.glenoid.superior");
}

}  // namespace reamsim
