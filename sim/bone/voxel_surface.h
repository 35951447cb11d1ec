// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// The surface of the bone in a partly filled voxel: the plane across the gradient of the fill that leaves the voxel's
/// fill on its inner side (Parker and Youngs 1992, AWE preprint 01/92). Bone is where normal·(p − centre) ≤ offset_mm.
struct VoxelPlane {
  Vec3 normal;  ///< unit vector out of the bone
  double offset_mm = 0;
};

/// The remaining fraction of a voxel, 0…1; 0 in air and outside the lattice.
inline double bone_fraction(const BoneView& bone, const Vec3i& voxel) {
  if (!bone.voxmap.is_bone(voxel)) return 0;
  return static_cast<double>(bone.fill.get(voxel)) / FillBricks::kWhole;
}

/// nullopt for a whole voxel, which is a cube of bone. `fallback`: unit normal where the fill has no gradient.
std::optional<VoxelPlane> voxel_plane(const BoneView& bone, const Vec3i& voxel, const Vec3& fallback);

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

/// Appends the surface in a voxel: its plane (voxel_plane()), or the faces of a whole one beside which is no bone.
void add_surface_patches(const BoneView& bone, const Vec3i& voxel, std::vector<SurfacePatch>& out);

/// Appends the whole surface of the part of a voxel on the inner side of planes, also where bone lies beside it.
void add_solid_patches(const Vec3& voxel_center, double voxel_mm, std::span<const VoxelPlane> planes,
                       std::vector<SurfacePatch>& out);

}  // namespace reamsim
