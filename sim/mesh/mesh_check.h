// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// An edge of one triangle. `low` < `high`; `forward` if the triangle has them in this order.
struct EdgeSide {
  std::int32_t low = 0;
  std::int32_t high = 0;
  bool forward = false;
  std::uint32_t triangle = 0;
};

/// The edges of all triangles but collapsed ones, by their vertices and then by their triangle.
std::vector<EdgeSide> sorted_sides(const std::vector<MeshTriangle>& triangles);

/// Calls visit(sides) for each edge with the sides of its triangles.
template <class Visit>
void for_each_edge(const std::vector<MeshTriangle>& triangles, const Visit& visit) {
  const std::vector<EdgeSide> sides = sorted_sides(triangles);
  for (auto first = sides.begin(); first != sides.end();) {
    auto last = first;
    while (last != sides.end() && last->low == first->low && last->high == first->high) ++last;
    visit(std::span<const EdgeSide>(first, last));
    first = last;
  }
}

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
MeshDiagnosis diagnose(const TriangleMesh& mesh);

/// The component of each triangle, from 0. Components are connected by shared vertices.
std::vector<std::size_t> components_of(const TriangleMesh& mesh);

/// A closed line at which the surface ends: where its edges are counted with the direction that they have in each
/// triangle, they do not add up to zero. Besides the rims of holes these are those of loose flaps.
struct MeshHole {
  std::vector<std::int32_t> rim;  ///< vertices, in the order in which they close the hole
  Vec3 centre_mm = Vec3::Zero();  ///< mean of the vertices
  double area_mm2 = 0;            ///< of the triangles from the centre to the rim
  double width_mm = 0;            ///< second of the three extents along its principal axes: small for a crack
  double length_mm = 0;           ///< twice the largest distance of a vertex of the rim from the centre
};

/// The largest area first.
std::vector<MeshHole> holes_of(const TriangleMesh& mesh);

/// Whether holes are so small that closing them changes no volume to speak of.
bool are_small(const std::vector<MeshHole>& holes, double surface_mm2);
inline constexpr double kSmallHoles = 0.005;  ///< of the surface, together
inline constexpr double kSmallHoleWidth_mm = 3;

/// "3 holes, 2.1 mm2 (0.01 % of the surface) together, the widest 0.8 mm at (1.0, 2.0, 3.0) mm".
std::string text_of(const std::vector<MeshHole>& holes, double surface_mm2);

/// A surface of a mesh that shares no vertex with the others.
struct MeshPiece {
  double volume_mm3 = 0;  ///< without sign
  Vec3 centre_mm = Vec3::Zero();
  bool inside_another = false;  ///< enclosed by another piece
  bool faces_inwards = false;   ///< its signed volume is negative: right for the wall of a cavity only
};

/// The pieces of a mesh, which has closed surfaces, and the number of the piece of each triangle.
struct NumberedPieces {
  std::vector<MeshPiece> pieces;
  std::vector<std::size_t> piece_of;
};
NumberedPieces numbered_pieces(const TriangleMesh& mesh);

/// The mesh without pieces inside others.
TriangleMesh outer_surface(const TriangleMesh& mesh);

/// Turns the triangles of each piece outside the others outwards; those inside another stay as they are, unless `all`.
/// Returns the pieces of the mesh, which has closed surfaces, as they were: the largest volume first.
std::vector<MeshPiece> turn_outwards(TriangleMesh& mesh, bool all = false);

/// The volume of the pieces outside the others: a surface inside another does not create a cavity.
double outer_volume_mm3(const std::vector<MeshPiece>& pieces);

/// Sentences after turn_outwards(): on pieces that faced inwards, beside the largest, inside another.
std::vector<std::string> warnings_of(const std::vector<MeshPiece>& pieces);

/// What clean() and close_holes() did.
struct RepairResult {
  std::size_t dropped_triangles = 0;  ///< collapsed or doubled
  std::size_t turned_triangles = 0;   ///< for one orientation of each surface
  std::size_t closed_holes = 0;
  std::size_t added_triangles = 0;
  double widest_hole_mm = 0;  ///< twice the largest distance of a rim vertex from the centre of its hole

  [[nodiscard]] std::string text() const;
};

/// Removes collapsed and doubled triangles, and turns triangles to the orientation that most of their surface has. Of
/// two on each other with opposite orientations one is kept where the surface would have a hole without it.
RepairResult clean(TriangleMesh& mesh);

/// Closes each hole with a fan from its centre. Then every point has a whole winding number.
void close_holes(TriangleMesh& mesh, const std::vector<MeshHole>& holes, RepairResult& done);

/// Merges vertices at the edges of holes that differ in their last digits, as programs write them: within 10⁻⁵ of the
/// size of the mesh and a tenth of its shortest edge that is longer than the rounding of the coordinates. Returns a
/// sentence on what was welded; "" where nothing was.
std::string weld(TriangleMesh& mesh);

}  // namespace reamsim
