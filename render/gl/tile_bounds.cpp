// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/gl/tile_bounds.h"

#include <algorithm>
#include <cmath>

namespace reamsim {
namespace {

/// Sine of the angle within which a triangle seen edge-on counts as visible, because its corners are rounded to
/// subpixels.
constexpr double kEdgeOnSine = 0.02;

Vec3 corner_mm(const BoneSurface& surface, std::uint32_t vertex) {
  return Eigen::Map<const Eigen::Vector3f>(surface.vertices.data() + vertex * BoneSurface::kStride).cast<double>();
}

/// The unit normals of all triangles that are not degenerate.
std::vector<Vec3> triangle_normals(const BoneSurface& surface) {
  std::vector<Vec3> normals;
  normals.reserve(surface.indices.size() / 3);
  for (std::size_t i = 0; i + 2 < surface.indices.size(); i += 3) {
    const Vec3 a = corner_mm(surface, surface.indices[i]);
    const Vec3 b = corner_mm(surface, surface.indices[i + 1]);
    const Vec3 c = corner_mm(surface, surface.indices[i + 2]);
    const Vec3 normal = (b - a).cross(c - a);
    if (normal.squaredNorm() > 0) normals.push_back(normal.normalized());
  }
  return normals;
}

/// Is the box outside one plane of the view frustum?
bool outside_frustum(const Eigen::AlignedBox3d& box_mm, const Camera& camera) {
  const Eigen::Matrix4d clip_from_bone = camera.clip_from_bone();
  std::array<int, 6> outside{};
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner = box_mm.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    const Eigen::Vector4d p = clip_from_bone * corner.homogeneous();
    for (int axis = 0; axis < 3; ++axis) {
      outside[static_cast<std::size_t>(2 * axis)] += p[axis] > p.w() ? 1 : 0;
      outside[static_cast<std::size_t>(2 * axis + 1)] += p[axis] < -p.w() ? 1 : 0;
    }
  }
  return std::ranges::any_of(outside, [](int corners) { return corners == 8; });
}

bool cut_away(const Eigen::AlignedBox3d& box_mm, const Eigen::Vector4d& plane) {
  const Vec3 normal = plane.head<3>();
  return normal.dot(box_mm.center()) + plane.w() + normal.cwiseAbs().dot(box_mm.sizes() / 2) < 0;
}

/// Are all triangles seen from behind?
bool faces_away(const TileBounds& bounds, const Camera& camera) {
  if (bounds.normal_cone_sine >= 1) return false;
  const double sine = bounds.normal_cone_sine + kEdgeOnSine;
  if (!camera.eye_mm) {
    const Vec3 towards_eye = camera.eye_from_bone.linear().transpose().col(2);
    return bounds.mean_normal.dot(towards_eye) < -sine;
  }
  const Vec3 eye = camera.eye_from_bone.inverse() * Vec3(0, 0, *camera.eye_mm);
  const Vec3 away = bounds.box_mm.center() - eye;
  // Over the bounding sphere of the box, the vector to the eye varies by at most the sphere's radius.
  return bounds.mean_normal.dot(away) > sine * away.norm() + bounds.box_mm.diagonal().norm() / 2;
}

}  // namespace

TileBounds tile_bounds(const BoneSurface& surface) {
  TileBounds out;
  for (const std::uint32_t vertex : surface.indices) out.box_mm.extend(corner_mm(surface, vertex));
  const std::vector<Vec3> normals = triangle_normals(surface);
  Vec3 sum = Vec3::Zero();
  for (const Vec3& normal : normals) sum += normal;
  if (sum.norm() < 1e-9) return out;
  out.mean_normal = sum.normalized();
  double cosine = 1;
  for (const Vec3& normal : normals) cosine = std::min(cosine, normal.dot(out.mean_normal));
  if (cosine > 0) out.normal_cone_sine = std::sqrt(1 - cosine * cosine);
  return out;
}

bool may_be_visible(const TileBounds& bounds, const Camera& camera) {
  if (outside_frustum(bounds.box_mm, camera)) return false;
  if (camera.cut_plane) return !cut_away(bounds.box_mm, *camera.cut_plane);
  return !faces_away(bounds, camera);
}

}  // namespace reamsim
