#pragma once

#include <cmath>
#include <cstdint>

#include "sim/base/geometry.h"

namespace reamsim {

/// An isotropic, axis-aligned voxel lattice in the bone frame B. Voxel (0,0,0) has its lower corner at `origin_mm`;
/// voxel (i,j,k) is stored at i + nx·(j + ny·k).
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
  [[nodiscard]] bool contains(const Vec3i& c) const {
    return (c.array() >= 0).all() && (c.array() < dims.array()).all();
  }
  /// The voxel that holds a point of B; may lie outside the grid.
  [[nodiscard]] Vec3i voxel_of(const Vec3& point_mm) const {
    return ((point_mm - origin_mm) / voxel_mm).array().floor().cast<int>();
  }
  [[nodiscard]] Aabb bounds_mm() const { return {origin_mm, origin_mm + voxel_mm * dims.cast<double>()}; }
  [[nodiscard]] double voxel_mm3() const { return voxel_mm * voxel_mm * voxel_mm; }
};

}  // namespace reamsim
