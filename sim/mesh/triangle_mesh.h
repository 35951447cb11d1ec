#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

/// A triangle mesh, vertices in mm in its owner's frame, triangles counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<std::array<std::int32_t, 3>> triangles;

  /// Bounds of the vertices; empty mesh: min > max.
  [[nodiscard]] Aabb bounds() const;
  /// Enclosed volume in mm³ by the divergence theorem; positive when the triangles face outwards.
  [[nodiscard]] double volume_mm3() const;
};

}  // namespace reamsim
