// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/base/error.h"
#include "sim/mesh/mesh_io.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The surface of a bone, in LPS mm, without holes, its triangles facing outwards.
struct BoneMesh {
  TriangleMesh mesh;
  double outer_mm3 = 0;   ///< outer_volume_mm3()
  bool was_clean = true;  ///< nothing was closed, dropped or turned
  bool nested = false;    ///< a surface lies inside another
};

/// Reads the mesh of the scenario, and notes its frame, size and state. Small holes (are_small()) are closed with a
/// warning, larger ones on request (bone.mesh.repair). Throws InputError: unreadable, wrong unit for a bone with a
/// glenoid, larger holes, triangles that cannot be oriented alike, no volume, a repair that changes too much volume.
BoneMesh read_bone_mesh(const BoneSettings& settings, Diagnostics& report);

/// Brings the vertices of a mesh into LPS, and notes in which frame it was read and why; warns where key and header
/// contradict each other. Without a statement the coordinates are taken as they stand. `key`: the scenario's key of the
/// frame, "" where it has none. Throws InputError: the header states another frame than LPS and RAS, and the key none.
void bring_into_lps(MeshContents& contents, MeshFrame asked, const std::string& path, const std::string& key,
                    Diagnostics& report);

/// Whether boxes that do not meet would after a half turn about z of one of them.
bool meet_after_half_turn_only(const Aabb& a, const Aabb& b);

struct FoundScale {
  double scale = 1;      ///< file units to mm
  std::string unit;      ///< "metres"
  double length_mm = 0;  ///< longest side of the mesh, with the scale
  bool assumed = false;  ///< no unit is likely: mm, although a scapula is longer or shorter
};

/// The unit in which the mesh of a file has the length of a scapula, or else mm. Throws InputError: unreadable, or an
/// unknown unit; then with the scales that would fit, after the words `what_to_set`.
FoundScale find_scale_of(const std::string& path, const std::string& what_to_set);

/// Throws InputError where, with this scale, the mesh is not 20 to 400 mm long, as find_scale_of().
void require_scale(const std::string& path, double scale, const std::string& what_to_set);

}  // namespace reamsim
