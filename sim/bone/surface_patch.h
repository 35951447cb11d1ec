// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <span>
#include <vector>

#include "sim/bone/voxel_surface.h"

namespace reamsim {

/// A convex plane polygon of the surface of a bone or mesh, B.
struct SurfacePatch {
  static constexpr std::size_t kMost = 10;  ///< vertices: six of a cube's section, and one for each plane that clips it
  std::array<Vec3, kMost> vertices;
  std::size_t count = 0;
  Vec3 normal = Vec3::UnitZ();  ///< unit vector
  Vec3 center = Vec3::Zero();   ///< mean of the vertices
  double radius_mm = 0;         ///< largest distance of a vertex from the centre

  /// Sets centre and radius from the vertices.
  void measure();
  /// Cuts off what lies outside a plane of a voxel.
  void clip(const VoxelPlane& plane, const Vec3& voxel_center);
  /// The point of the polygon nearest to a given one.
  [[nodiscard]] Vec3 nearest(const Vec3& point) const;
};

/// Appends the surface of the bone in a voxel: the plane of a partly filled voxel within it (voxel_plane()), and the
/// faces of a whole one beside which there is no bone.
void add_surface_patches(const BoneView& bone, const Vec3i& voxel, std::vector<SurfacePatch>& out);

/// Appends the whole surface of the part of a voxel on the inner side of planes, also where bone lies beside it.
void add_solid_patches(const Vec3& voxel_center, double voxel_mm, std::span<const VoxelPlane> planes,
                       std::vector<SurfacePatch>& out);

}  // namespace reamsim
