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

/// A surface of a mesh that shares no vertex with the others.
struct MeshPiece {
  double volume_mm3 = 0;  ///< without sign
  Vec3 centre_mm = Vec3::Zero();
  bool inside_another = false;  ///< enclosed by another piece
  bool faces_inwards = false;   ///< its signed volume is negative: right for the wall of a cavity only
};

/// Turns the triangles of each piece outside the others outwards; those inside another stay as they are, unless `all`.
/// Returns the pieces of the mesh, which has closed surfaces, as they were: the largest volume first.
std::vector<MeshPiece> turn_outwards(TriangleMesh& mesh, bool all = false);

/// The volume of the pieces outside the others, which is what voxels of them have: a surface inside another does not
/// create a cavity.
double outer_volume_mm3(const std::vector<MeshPiece>& pieces);

/// What to say of a mesh that becomes one bone after turn_outwards(): a sentence for pieces that faced inwards, one for
/// those beside the largest, one for those inside another; empty for one piece that faces outwards.
std::vector<std::string> warnings_of(const std::vector<MeshPiece>& pieces);

}  // namespace reamsim
