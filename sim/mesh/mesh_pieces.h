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
};

/// The pieces of a mesh of closed surfaces, the largest volume first.
std::vector<MeshPiece> pieces_of(const TriangleMesh& mesh);

/// What to say of a mesh with several pieces that becomes one bone: one sentence for those beside the largest, one for
/// those inside another; empty for one piece.
std::vector<std::string> warnings_of(const std::vector<MeshPiece>& pieces);

}  // namespace reamsim
