// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "sim/base/geometry.h"

namespace reamsim {

/// An isotropic, axis-aligned voxel lattice in the bone frame B. Voxel (0,0,0) has its lower corner at `origin_mm`;
/// voxel (i,j,k) has the index i + nx·(j + ny·k).
struct VoxelGrid {
  Vec3i dims = Vec3i::Zero();
  double voxel_mm = 0;
  Vec3 origin_mm = Vec3::Zero();

  [[nodiscard]] std::int64_t size() const { return std::int64_t{1} * dims.x() * dims.y() * dims.z(); }
  [[nodiscard]] std::int64_t index(const Vec3i& v) const {
    return v.x() + std::int64_t{dims.x()} * (v.y() + std::int64_t{dims.y()} * v.z());
  }
  [[nodiscard]] Vec3i coord(std::int64_t index) const {
    const std::int64_t row = index / dims.x();
    return {static_cast<int>(index % dims.x()), static_cast<int>(row % dims.y()), static_cast<int>(row / dims.y())};
  }
  [[nodiscard]] Vec3 center_mm(const Vec3i& v) const {
    return origin_mm + voxel_mm * (v.cast<double>() + Vec3::Constant(0.5));
  }
  [[nodiscard]] bool contains(const Vec3i& v) const {
    return (v.array() >= 0).all() && (v.array() < dims.array()).all();
  }
  /// The voxel that contains a point of B; it may lie outside the grid.
  [[nodiscard]] Vec3i voxel_of(const Vec3& point_mm) const {
    return ((point_mm - origin_mm) / voxel_mm).array().floor().cast<int>();
  }
  [[nodiscard]] Aabb bounds_mm() const { return {origin_mm, origin_mm + voxel_mm * dims.cast<double>()}; }
  [[nodiscard]] double voxel_mm3() const { return voxel_mm * voxel_mm * voxel_mm; }
};

/// Calls visit(voxel) for the voxels from `first` to `last`, both included; x varies fastest.
template <class Visit>
void for_each_voxel(const Vec3i& first, const Vec3i& last, const Visit& visit) {
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) visit(Vec3i(x, y, z));
    }
  }
}
/// Calls visit(voxel) for all voxels of a lattice.
template <class Visit>
void for_each_voxel(const Vec3i& dims, const Visit& visit) {
  for_each_voxel(Vec3i::Zero(), dims - Vec3i::Ones(), visit);
}

/// Calls visit(step, weight) for the eight voxels of a trilinear interpolation whose weight is not 0. `step` is 0 or 1
/// along each axis; `fraction` is the position between the lower and the upper voxel.
template <class Visit>
void for_each_trilinear_weight(const Vec3& fraction, const Visit& visit) {
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3i step(corner & 1, corner >> 1 & 1, corner >> 2);
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) weight *= step[axis] != 0 ? fraction[axis] : 1 - fraction[axis];
    if (weight != 0) visit(step, weight);
  }
}

/// Air around a bone. Pictures and the grid `surface` smooth the surface and need it.
inline constexpr int kMarginVoxels = 4;

/// Measured memory per voxel while a mesh is voxelized: grades, distance field, and temporary copies.
inline constexpr double kMeshBytesPerVoxel = 13;

/// Which part of a lattice needs memory while the bone is built.
struct LatticeLoad {
  double bone_fraction = 1;    ///< upper bound of the fraction of the lattice in bricks with bone, 0…1
  double bytes_per_voxel = 1;  ///< in these bricks: one byte of grade, and what the source of the bone needs
};

double machine_memory_bytes();

/// Throws InputError, with the voxel size that would fit, unless a lattice of `dims` voxels (doubles, against overflow)
/// can be indexed and its load fits into half of `memory_bytes`. The message begins with `what`.
void check_lattice(const std::string& what, const Eigen::Array3d& dims, double voxel_mm, const LatticeLoad& load = {},
                   double memory_bytes = machine_memory_bytes());

/// The lattice of `voxel_mm` around `box_mm` with a margin of `margin_voxels`. Its planes lie at multiples of the voxel
/// size from the origin of B; its dimensions are multiples of 8 (whole bricks). Throws as check_lattice().
VoxelGrid lattice_around(const std::string& what, const Aabb& box_mm, double voxel_mm, int margin_voxels,
                         const LatticeLoad& load = {});

}  // namespace reamsim
