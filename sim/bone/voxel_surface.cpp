// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/voxel_surface.h"

#include <algorithm>
#include <cmath>

#include "kernels/cube_fraction.h"
#include "sim/bone/implicit.h"

namespace reamsim {

namespace {

constexpr int kHalvings = 24;
constexpr double kLeastGradient = 1e-6;

/// Gradient of the bone's fraction over the 3×3×3 voxels around one. The weights 1, 2, 1 across each axis make it that
/// of a plane to within a few degrees.
Vec3 fraction_gradient(const BoneView& bone, const Vec3i& voxel) {
  Vec3 out = Vec3::Zero();
  for_each_voxel(Vec3i::Constant(-1), Vec3i::Ones(), [&](const Vec3i& step) {
    const double fraction = bone_fraction(bone, voxel + step);
    if (fraction == 0) return;
    for (int axis = 0; axis < 3; ++axis) {
      const int across = step.cwiseAbs().sum() - std::abs(step[axis]);
      out[axis] += fraction * step[axis] * (across == 0 ? 4 : across == 1 ? 2 : 1);
    }
  });
  return out;
}

/// Distance of the plane from the centre of a unit cube of which it leaves `fraction` on its inner side.
double plane_offset(const Vec3& normal, double fraction) {
  const float n[3] = {static_cast<float>(normal.x()), static_cast<float>(normal.y()), static_cast<float>(normal.z())};
  const auto leaves_less = [&](double offset) {
    return 1 - double{rs_outside_fraction(n, static_cast<float>(-offset))} < fraction;
  };
  return implicit::bisect(-RS_CLIP_REACH, RS_CLIP_REACH, kHalvings, leaves_less).middle();
}

/// The section of a plane with a cube of side 2·`half_mm` around `center`.
SurfacePatch section_of_cube(const VoxelPlane& plane, const Vec3& center, double half_mm) {
  SurfacePatch out;
  out.normal = plane.normal;
  const Aabb cube{Vec3::Constant(-half_mm), Vec3::Constant(half_mm)};
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      if ((corner >> axis & 1) != 0) continue;
      const Vec3 from = cube.corner(corner), to = cube.corner(corner | 1 << axis);
      const double a = plane.normal.dot(from) - plane.offset_mm, b = plane.normal.dot(to) - plane.offset_mm;
      if ((a < 0) == (b < 0) || out.count == 6) continue;
      out.vertices[out.count++] = center + from + (to - from) * (a / (a - b));
    }
  }
  if (out.count < 3) return out;
  out.measure();
  // In order around the centre.
  const Vec3 x = plane.normal.unitOrthogonal(), y = plane.normal.cross(x);
  const auto angle = [&](const Vec3& p) { return std::atan2((p - out.center).dot(y), (p - out.center).dot(x)); };
  std::sort(out.vertices.begin(), out.vertices.begin() + static_cast<std::ptrdiff_t>(out.count),
            [&](const Vec3& a, const Vec3& b) { return angle(a) < angle(b); });
  return out;
}

SurfacePatch face_of_cube(const Vec3& center, double half_mm, int axis, int side) {
  SurfacePatch out;
  out.normal = side * Vec3::Unit(axis);
  const Vec3 u = half_mm * Vec3::Unit((axis + 1) % 3), v = half_mm * Vec3::Unit((axis + 2) % 3);
  const Vec3 middle = center + half_mm * out.normal;
  for (const Vec3& corner : {Vec3(u + v), Vec3(v - u), Vec3(-u - v), Vec3(u - v)}) {
    out.vertices[out.count++] = middle + corner;
  }
  out.measure();
  return out;
}

}  // namespace

std::optional<VoxelPlane> voxel_plane(const BoneView& bone, const Vec3i& voxel, const Vec3& fallback) {
  const double fraction = bone_fraction(bone, voxel);
  if (fraction >= 1) return std::nullopt;
  const Vec3 gradient = fraction_gradient(bone, voxel);
  const double length = gradient.norm();
  const Vec3 normal = length > kLeastGradient ? Vec3(-gradient / length) : fallback;
  return VoxelPlane{normal, bone.voxmap.grid.voxel_mm * plane_offset(normal, fraction)};
}

void SurfacePatch::measure() {
  center = Vec3::Zero();
  for (std::size_t i = 0; i < count; ++i) center += vertices[i] / static_cast<double>(count);
  radius_mm = 0;
  for (std::size_t i = 0; i < count; ++i) radius_mm = std::max(radius_mm, (vertices[i] - center).norm());
}

void SurfacePatch::clip(const VoxelPlane& plane, const Vec3& voxel_center) {
  SurfacePatch kept;
  kept.normal = normal;
  const auto above = [&](const Vec3& p) { return plane.normal.dot(p - voxel_center) - plane.offset_mm; };
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 &a = vertices[i], &b = vertices[(i + 1) % count];
    const double from = above(a), to = above(b);
    if (from <= 0 && kept.count < kMost) kept.vertices[kept.count++] = a;
    if ((from <= 0) != (to <= 0) && kept.count < kMost) {
      kept.vertices[kept.count++] = a + (b - a) * (from / (from - to));
    }
  }
  if (kept.count > 0) kept.measure();
  *this = kept;
}

Vec3 SurfacePatch::nearest(const Vec3& point) const {
  const Vec3 flat = point - normal.dot(point - center) * normal;
  bool inside = true;
  Vec3 best = vertices[0];
  double best_mm2 = (best - flat).squaredNorm();
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& a = vertices[i];
    const Vec3 edge = vertices[(i + 1) % count] - a;
    // The centre tells the inner side of an edge, in either order of the vertices. A polygon without area has none.
    const Vec3 across = normal.cross(edge);
    inside &= across.dot(flat - a) * across.dot(center - a) > 0;
    const double length2 = edge.squaredNorm();
    const double part = length2 > 0 ? std::clamp(edge.dot(flat - a) / length2, 0.0, 1.0) : 0;
    const Vec3 here = a + part * edge;
    const double mm2 = (here - flat).squaredNorm();
    if (mm2 >= best_mm2) continue;
    best = here;
    best_mm2 = mm2;
  }
  return inside ? flat : best;
}

void add_surface_patches(const BoneView& bone, const Vec3i& voxel, std::vector<SurfacePatch>& out) {
  if (bone_fraction(bone, voxel) == 0) return;
  const Vec3 center = bone.voxmap.grid.center_mm(voxel);
  const double half_mm = 0.5 * bone.voxmap.grid.voxel_mm;
  if (const std::optional<VoxelPlane> plane = voxel_plane(bone, voxel, Vec3::UnitZ())) {
    const SurfacePatch section = section_of_cube(*plane, center, half_mm);
    if (section.count >= 3) out.push_back(section);
    return;
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      const Vec3i beside = voxel + side * Vec3i(Vec3i::Unit(axis));
      if (bone_fraction(bone, beside) == 0) out.push_back(face_of_cube(center, half_mm, axis, side));
    }
  }
}

void add_solid_patches(const Vec3& voxel_center, double voxel_mm, std::span<const VoxelPlane> planes,
                       std::vector<SurfacePatch>& out) {
  const double half_mm = 0.5 * voxel_mm;
  const auto add = [&](SurfacePatch patch, const VoxelPlane* own) {
    for (const VoxelPlane& plane : planes) {
      if (&plane != own) patch.clip(plane, voxel_center);
    }
    if (patch.count >= 3) out.push_back(patch);
  };
  for (const VoxelPlane& plane : planes) add(section_of_cube(plane, voxel_center, half_mm), &plane);
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) add(face_of_cube(voxel_center, half_mm, axis, side), nullptr);
  }
}

}  // namespace reamsim
