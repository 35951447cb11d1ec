// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

using MeshTriangle = std::array<std::int32_t, 3>;

inline bool is_collapsed(const MeshTriangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

/// A triangle mesh, vertices in mm in its owner's frame, triangles counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<MeshTriangle> triangles;

  [[nodiscard]] const Vec3& vertex(std::int32_t index) const { return vertices[static_cast<std::size_t>(index)]; }
  [[nodiscard]] std::array<Vec3, 3> corners(const MeshTriangle& t) const {
    return {vertex(t[0]), vertex(t[1]), vertex(t[2])};
  }
  /// Bounding box of the vertices; empty mesh: min > max.
  [[nodiscard]] Aabb bounds() const {
    Aabb box = Aabb::none();
    for (const Vec3& vertex : vertices) box.extend(vertex);
    return box;
  }
  /// Enclosed volume in mm³ by the divergence theorem; positive when the triangles face outwards.
  [[nodiscard]] double volume_mm3() const {
    if (vertices.empty()) return 0;
    const Vec3 pivot = bounds().center();  // near the mesh, for accuracy far from the origin
    double six_volumes = 0;
    for (const auto& triangle : triangles) {
      const auto [a, b, c] = corners(triangle);
      const Vec3 pa = a - pivot, pb = b - pivot, pc = c - pivot;
      six_volumes += pa.dot(pb.cross(pc));
    }
    return six_volumes / 6;
  }
  [[nodiscard]] double area_mm2() const {
    double sum = 0;
    for (const MeshTriangle& triangle : triangles) {
      const auto [a, b, c] = corners(triangle);
      sum += 0.5 * (b - a).cross(c - a).norm();
    }
    return sum;
  }
};

}  // namespace reamsim
