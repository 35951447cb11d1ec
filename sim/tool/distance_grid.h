// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/mesh/triangle_mesh.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// The signed distance to a closed mesh next to its surface, negative inside, in the mesh's frame: samples on a cubic
/// lattice with trilinear interpolation. A brick of 8×8×8 cells stores the samples at all corners of its cells.
struct DistanceGrid {
  static constexpr int kSide = 8;         ///< cells of a brick along an axis
  static constexpr int kRow = kSide + 1;  ///< samples
  static constexpr std::size_t kSamples = std::size_t{kRow} * kRow * kRow;
  static constexpr std::uint32_t kOutside = 0, kInside = 1;  ///< slots of bricks far from the surface

  Vec3 origin_mm = Vec3::Zero();  ///< sample (0,0,0)
  double spacing_mm = 0;
  double band_mm = 0;   ///< distances are clamped to it
  double slack_mm = 0;  ///< distance outside the envelope minus sampled distance from the surface, at most
  Vec3i bricks = Vec3i::Zero();
  std::vector<std::uint32_t> slot_of_brick;  ///< x fastest
  std::vector<float> samples;                ///< mm, slot by slot, x fastest
  double volume_mm3 = 0;                     ///< inside by the trilinear distance
  double mesh_mm3 = 0;                       ///< inside the mesh

  [[nodiscard]] double volume_error() const { return volume_mm3 / mesh_mm3 - 1; }
  [[nodiscard]] std::size_t stored_bricks() const { return samples.size() / kSamples; }
  [[nodiscard]] std::size_t bytes() const {
    return samples.size() * sizeof(float) + slot_of_brick.size() * sizeof(std::uint32_t);
  }
};

inline constexpr double kGridSpacingVoxels = 0.5;  ///< spacing of a tool's grid, voxels

/// For a closed mesh that faces outwards (T, mm) and its envelope. The band contains all voxels that the surface can
/// intersect within a window of substeps. Throws InputError where OpenVDB computes no distance.
DistanceGrid make_distance_grid(const TriangleMesh& mesh, const Profile& envelope, double voxel_mm);

/// Bounds of the memory of make_distance_grid(), bytes: during the computation, and of its result.
struct DistanceGridPlan {
  double working_bytes = 0;
  double kept_bytes = 0;
};
DistanceGridPlan plan_distance_grid(const TriangleMesh& mesh, double voxel_mm);

/// Throws InputError with the voxel size that would fit where `need_bytes` exceed `have_bytes`, the memory of `what`.
void require_room_for_grid(double need_bytes, double have_bytes, double voxel_mm, const std::string& what);

/// Signed distances to a tool's surface on a grid in (r, z), mm, negative inside: for predictions, lists of bricks.
struct DistanceTable {
  Vec2 first = Vec2::Zero();  ///< (r, z) of the first sample
  double pitch_mm = 1;
  int count_r = 0;
  int count_z = 0;
  std::vector<float> mm;  ///< r fastest

  /// Interpolated at (r, z); infinite beyond the last samples.
  [[nodiscard]] double at(const Vec2& rz) const;
  /// The value of the nearest sample; infinite beyond the samples.
  [[nodiscard]] double nearest(const Vec2& rz) const;
};

/// Over the profile's box and `margin_mm` round it.
DistanceTable distance_table_around(const Profile& profile, double pitch_mm, double margin_mm);

DistanceTable make_distance_table(const Profile& profile, const Vec2& first, double pitch_mm, int count_r, int count_z);

/// Whether the triangle abc shares a point with the closed box about `center` with half edges `half` (any one unit), by
/// separating axes (Akenine-Möller 2001, "Fast 3D triangle-box overlap testing").
bool triangle_touches_box(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& center, const Vec3& half);

}  // namespace reamsim
