// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim::test {

/// a without b by CGAL's corefinement: exact predicates; intersection points are rounded to double precision. Both are
/// closed and face outwards. Throws std::runtime_error: a mesh intersects itself at the other, or the result is not
/// closed.
TriangleMesh mesh_difference(const TriangleMesh& a, const TriangleMesh& b);

/// The distance of each point from a surface, mm.
std::vector<double> distances_mm(const std::vector<Vec3>& points, const TriangleMesh& surface);

}  // namespace reamsim::test
