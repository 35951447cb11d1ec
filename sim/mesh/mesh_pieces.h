// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

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
