// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/base/error.h"
#include "sim/mesh/triangle_mesh.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The surface of a bone, in LPS mm (mesh_frame.h), without holes, its triangles facing outwards.
struct BoneMesh {
  TriangleMesh mesh;
  double outer_mm3 = 0;   ///< outer_volume_mm3()
  bool was_clean = true;  ///< nothing was closed, dropped or turned
};

/// Reads the mesh of the scenario, and notes its frame, size and state. Holes that are small (HoleLimits) are closed
/// with a warning, larger ones on request (bone.mesh.repair). Throws InputError, the unit before the holes: unreadable,
/// wrong unit for a bone with a glenoid, larger holes, triangles that cannot be oriented alike, no volume, a repair
/// that changes the volume by more than the scenario allows.
BoneMesh read_bone_mesh(const BoneSettings& settings, Diagnostics& report);

}  // namespace reamsim
