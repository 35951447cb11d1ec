// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// Defects of a mesh as the boundary of a solid. All zero for a closed, two-manifold, consistently oriented mesh.
struct MeshDiagnosis {
  std::size_t boundary_edges = 0;      ///< edges with one triangle: a hole
  std::size_t nonmanifold_edges = 0;   ///< edges with three or more triangles
  std::size_t inconsistent_edges = 0;  ///< edges between triangles with opposite orientation
  std::size_t degenerate_triangles = 0;
  std::size_t components = 0;
  double volume_mm3 = 0;                     ///< signed; negative: the mesh is inside out
  std::optional<Vec3> first_hole_mm;         ///< midpoint of the first boundary edge
  std::optional<Vec3> first_nonmanifold_mm;  ///< midpoint of the first non-manifold edge

  [[nodiscard]] bool closed_manifold() const {
    return boundary_edges == 0 && nonmanifold_edges == 0 && inconsistent_edges == 0;
  }
  /// One line for an error message: counts and the position of the first defects.
  [[nodiscard]] std::string text() const;
};

/// The component of each triangle, from 0. Components are connected by shared vertices.
std::vector<std::size_t> components_of(const TriangleMesh& mesh);

MeshDiagnosis diagnose(const TriangleMesh& mesh);

}  // namespace reamsim
