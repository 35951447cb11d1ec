// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/bone_ray.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/bone/voxel_surface.h"

namespace reamsim {

namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

struct Ray {
  Vec3 from_mm;
  Vec3 direction;
};

/// A part of a ray, mm along it.
struct Span {
  double begin_mm;
  double end_mm;
};

/// The part of a ray in a box; empty where begin ≥ end.
Span clipped(const Ray& ray, const Aabb& box, Span span) {
  for (int axis = 0; axis < 3; ++axis) {
    if (ray.direction[axis] == 0) {
      if (ray.from_mm[axis] < box.min[axis] || ray.from_mm[axis] >= box.max[axis]) return {0, 0};
      continue;
    }
    const double a = (box.min[axis] - ray.from_mm[axis]) / ray.direction[axis];
    const double b = (box.max[axis] - ray.from_mm[axis]) / ray.direction[axis];
    span = {std::max(span.begin_mm, std::min(a, b)), std::min(span.end_mm, std::max(a, b))};
  }
  return span;
}

/// Calls visit(cell, span) for the cells from `first` to `last` of a lattice with cell (0,0,0) at `origin_mm`, in the
/// order of the ray within `span`, until a visit returns true (Amanatides and Woo 1987).
template <class Visit>
bool walk(const Ray& ray, const Vec3& origin_mm, double cell_mm, const Vec3i& first, const Vec3i& last, Span span,
          const Visit& visit) {
  const Vec3 place = (ray.from_mm + span.begin_mm * ray.direction - origin_mm) / cell_mm;
  Vec3i cell = place.array().floor().cast<int>();
  cell = cell.cwiseMax(first).cwiseMin(last);
  Vec3 next_mm;
  for (int axis = 0; axis < 3; ++axis) {
    const double side_mm = origin_mm[axis] + cell_mm * (cell[axis] + (ray.direction[axis] > 0 ? 1 : 0));
    next_mm[axis] = ray.direction[axis] == 0 ? kNever : (side_mm - ray.from_mm[axis]) / ray.direction[axis];
  }
  double at_mm = span.begin_mm;
  for (;;) {
    int axis = 0;
    next_mm.minCoeff(&axis);
    const double end_mm = std::min(next_mm[axis], span.end_mm);
    if (visit(cell, Span{at_mm, end_mm})) return true;
    if (next_mm[axis] >= span.end_mm) return false;
    at_mm = std::max(at_mm, end_mm);
    cell[axis] += ray.direction[axis] > 0 ? 1 : -1;
    if (cell[axis] < first[axis] || cell[axis] > last[axis]) return false;
    next_mm[axis] += cell_mm / std::abs(ray.direction[axis]);
  }
}

/// Where a ray meets the bone of a voxel.
std::optional<double> met_in_voxel(const BoneView& bone, const Ray& ray, const Vec3i& voxel, const Span& span) {
  const std::optional<VoxelPlane> plane = voxel_plane(bone, voxel, -ray.direction);
  if (!plane) return span.begin_mm;
  const double begin =
      plane->normal.dot(ray.from_mm + span.begin_mm * ray.direction - bone.voxmap.grid.center_mm(voxel)) -
      plane->offset_mm;
  if (begin <= 0) return span.begin_mm;
  const double slope = plane->normal.dot(ray.direction);
  const double at_mm = slope < 0 ? span.begin_mm - begin / slope : kNever;
  return at_mm <= span.end_mm ? std::optional(at_mm) : std::nullopt;
}

}  // namespace

std::optional<double> first_bone_mm(const BoneView& bone, const Vec3& from_mm, const Vec3& direction, double most_mm) {
  const VoxelGrid& grid = bone.voxmap.grid;
  const Ray ray{from_mm, direction};
  const Span within = clipped(ray, grid.bounds_mm(), {0, most_mm});
  if (within.begin_mm >= within.end_mm) return std::nullopt;
  const Vec3i bricks = bone.voxmap.grade.brick_dims();
  std::optional<double> met;
  const auto visit_brick = [&](const Vec3i& coord, const Span& in_brick) {
    const GradeBricks::Brick* grades = bone.voxmap.grade.brick(coord);
    if (grades == nullptr || in_brick.begin_mm >= in_brick.end_mm) return false;
    const Vec3i first = BrickLattice::kSide * coord;
    const Vec3i last = (first + Vec3i::Constant(BrickLattice::kSide)).cwiseMin(grid.dims) - Vec3i::Ones();
    return walk(ray, grid.origin_mm, grid.voxel_mm, first, last, in_brick, [&](const Vec3i& voxel, const Span& span) {
      if ((*grades)[static_cast<std::size_t>(BrickLattice::offset_of(voxel))] == 0) return false;
      if (bone.fill.get(voxel) == 0) return false;
      met = met_in_voxel(bone, ray, voxel, span);
      return met.has_value();
    });
  };
  walk(ray, grid.origin_mm, grid.voxel_mm * BrickLattice::kSide, Vec3i::Zero(), bricks - Vec3i::Ones(), within,
       visit_brick);
  return met && *met <= most_mm ? met : std::nullopt;
}

}  // namespace reamsim
