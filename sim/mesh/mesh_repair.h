#pragma once

#include <cstddef>
#include <string>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// What repair() did.
struct RepairResult {
  std::size_t dropped_triangles = 0;  ///< without area, or there twice
  std::size_t closed_holes = 0;
  std::size_t added_triangles = 0;
  double widest_hole_mm = 0;  ///< largest distance of a rim vertex from its hole's middle, doubled

  [[nodiscard]] std::string text() const;
};

/// Drops collapsed and repeated triangles and closes each hole with a fan from the middle of its rim. What is left
/// (non-manifold edges, opposite orientations) meshToVolume tolerates: it asks only which voxels are shut off from the
/// outside.
RepairResult repair(TriangleMesh& mesh);

}  // namespace reamsim
