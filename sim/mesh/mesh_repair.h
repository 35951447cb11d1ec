// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

struct RepairResult {
  std::size_t dropped_triangles = 0;  ///< collapsed or duplicate
  std::size_t turned_triangles = 0;   ///< for one orientation of each surface
  std::size_t closed_holes = 0;
  std::size_t added_triangles = 0;
  double widest_hole_mm = 0;  ///< twice the largest distance of a rim vertex from the centre of its hole

  [[nodiscard]] std::string text() const;
};

/// Removes collapsed and duplicate triangles, turns triangles to the orientation that most of their surface has, and
/// closes each hole with a fan from the centre of its rim. meshToVolume tolerates the remaining defects (non-manifold
/// edges, a surface that cannot be oriented): it only determines which voxels are separated from the outside.
RepairResult repair(TriangleMesh& mesh);

}  // namespace reamsim
