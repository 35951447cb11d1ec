// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

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

/// Closes each hole with a fan from its centre. Then every point has a whole winding number.
void close_holes(TriangleMesh& mesh, const std::vector<MeshHole>& holes);

/// Area of all triangles, mm².
double area_mm2(const TriangleMesh& mesh);

/// Holes so small that closing them changes no volume to speak of.
struct HoleLimits {
  static constexpr double kMostOfArea = 0.005;  ///< of the surface, together
  static constexpr double kMostWidth_mm = 3;
};
bool are_small(const std::vector<MeshHole>& holes, double surface_mm2);

/// "3 holes, 2.1 mm2 (0.01 % of the surface) together, the widest 0.8 mm at (1.0, 2.0, 3.0) mm".
std::string text_of(const std::vector<MeshHole>& holes, double surface_mm2);

}  // namespace reamsim
