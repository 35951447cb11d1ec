// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/mesh/mesh_check.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// What clean() and close_holes() did.
struct RepairResult {
  std::size_t dropped_triangles = 0;  ///< collapsed or doubled
  std::size_t turned_triangles = 0;   ///< for one orientation of each surface
  std::size_t closed_holes = 0;
  std::size_t added_triangles = 0;
  double widest_hole_mm = 0;  ///< twice the largest distance of a rim vertex from the centre of its hole

  [[nodiscard]] std::string text() const;
};

/// Removes collapsed triangles and the copies of doubled ones, and turns triangles to the orientation that most of
/// their surface has. Of triangles that lie on each other with opposite orientations one is kept where the surface
/// would have a hole without it; where it would be a loose flap, none.
RepairResult clean(TriangleMesh& mesh);

/// Closes each hole with a fan from its centre. Then every point has a whole winding number.
void close_holes(TriangleMesh& mesh, const std::vector<MeshHole>& holes, RepairResult& done);

/// Merges vertices that differ in their last digits, as programs write them that transform each triangle by itself:
/// only those at the edges of holes, within 10⁻⁵ of the size of the mesh and a tenth of its shortest edge. An edge that
/// is shorter than the rounding of the coordinates is none. A mesh without holes is not changed. Returns a sentence on
/// what was welded; "" where nothing was.
std::string weld(TriangleMesh& mesh);

}  // namespace reamsim
