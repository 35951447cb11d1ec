// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <vector>

#include "sim/bone/voxmap/voxel_grid.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// Where the columns of voxels along z lie inside a mesh: where its winding number (winding.h) is more than 0.
/// Overlaps, doubled faces and surfaces within the solid change nothing. The edges of the mesh must cancel
/// (mesh_holes.h).
class InsideColumns {
 public:
  InsideColumns(const TriangleMesh& mesh, const VoxelGrid& grid);

  /// Whether the centre of a voxel is inside; it may lie outside the grid.
  [[nodiscard]] bool contains(const Vec3i& voxel) const;
  /// Of the columns, mm³.
  [[nodiscard]] double volume_mm3() const { return volume_mm3_; }
  /// Whether the winding number is nowhere other than 0 or 1: no surface overlaps another.
  [[nodiscard]] bool is_simple() const { return simple_; }

 private:
  struct Part {
    double begin_mm = 0;
    double end_mm = 0;
  };

  VoxelGrid grid_;
  std::vector<std::size_t> first_;  ///< part of each column; one more at the end
  std::vector<Part> parts_;
  double volume_mm3_ = 0;
  bool simple_ = true;
};

/// The triangles at the boundary of the inside: without walls inside the solid and flaps outside. Triangles are divided
/// to edges of at most `edge_mm`, so that they end where surfaces cross. For distances only: it has cracks.
TriangleMesh boundary_of_inside(const TriangleMesh& mesh, double edge_mm);

}  // namespace reamsim
