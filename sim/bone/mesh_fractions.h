// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// The fractions of voxels inside a mesh, exact but for rounding. The mesh: closed, its triangles facing outwards,
/// below the top of the lattice. Not right where surfaces overlap().
class MeshFractions {
 public:
  MeshFractions(const TriangleMesh& mesh, const VoxelGrid& grid);

  /// The fraction, 0…1, of a voxel that triangles intersect; none of other voxels.
  [[nodiscard]] std::optional<double> at(const Vec3i& voxel) const;
  /// Whether a column of voxels enters the mesh twice without leaving it between.
  [[nodiscard]] bool overlap() const;

 private:
  using Fraction = std::pair<std::int64_t, float>;  ///< by key()

  /// In order along columns from above.
  [[nodiscard]] std::int64_t key(std::int64_t y, std::int64_t z) const { return (y + 1) * dims_.z() - 1 - z; }
  [[nodiscard]] std::vector<Fraction> fractions_in_layer(int x, const TriangleMesh& mesh, const VoxelGrid& grid,
                                                         const std::vector<std::uint32_t>& triangles) const;

  Vec3i dims_;
  std::vector<std::vector<Fraction>> layers_;  ///< by x, by key
};

}  // namespace reamsim
