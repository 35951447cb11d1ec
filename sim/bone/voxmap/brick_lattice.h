// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>

#include "sim/base/geometry.h"

namespace reamsim {

/// The bricks (8×8×8 voxels) that cover a lattice of voxels. Those at its upper borders may extend beyond it. Brick
/// (i,j,k) has the index i + nx·(j + ny·k).
struct BrickLattice {
  static constexpr int kSide = 8;
  static constexpr int kVoxels = kSide * kSide * kSide;

  Vec3i dims = Vec3i::Zero();  ///< bricks along each axis: ceil(voxels/8)

  static BrickLattice over(const Vec3i& voxels) { return {(voxels.array() + (kSide - 1)) / kSide}; }

  /// The brick that contains a voxel. Rounds down for negative coordinates as well.
  static Vec3i brick_of(const Vec3i& voxel) { return {voxel.x() >> 3, voxel.y() >> 3, voxel.z() >> 3}; }
  /// Voxel (x,y,z) of a brick has the offset x + 8·(y + 8·z).
  static int offset_of(const Vec3i& voxel) {
    return (voxel.x() & 7) + kSide * ((voxel.y() & 7) + kSide * (voxel.z() & 7));
  }
  static Vec3i voxel_at(const Vec3i& brick, int offset) {
    return kSide * brick + Vec3i(offset & 7, (offset >> 3) & 7, offset >> 6);
  }

  [[nodiscard]] std::size_t count() const { return index({0, 0, dims.z()}); }
  [[nodiscard]] std::size_t index(const Vec3i& brick) const {
    const auto nx = static_cast<std::size_t>(dims.x());
    const auto ny = static_cast<std::size_t>(dims.y());
    return static_cast<std::size_t>(brick.x()) +
           nx * (static_cast<std::size_t>(brick.y()) + ny * static_cast<std::size_t>(brick.z()));
  }
  [[nodiscard]] Vec3i coord(std::size_t index) const {
    const auto nx = static_cast<std::size_t>(dims.x());
    const auto ny = static_cast<std::size_t>(dims.y());
    const std::size_t row = index / nx;
    return {static_cast<int>(index % nx), static_cast<int>(row % ny), static_cast<int>(row / ny)};
  }
  [[nodiscard]] bool contains(const Vec3i& brick) const {
    return (brick.array() >= 0).all() && (brick.array() < dims.array()).all();
  }
};

}  // namespace reamsim
