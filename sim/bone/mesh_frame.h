// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/mesh/mesh_io.h"
#include "sim/scenario/choices.h"

namespace reamsim {

/// Brings the vertices of a mesh into LPS, and notes in which frame it was read and why; warns where key and header
/// contradict each other. Without a statement the coordinates are taken as they stand. `key`: the scenario's key of the
/// frame, "" where it has none. Throws InputError: the header states another frame than LPS and RAS, and the key none.
void bring_into_lps(MeshContents& contents, MeshFrame asked, const std::string& path, const std::string& key,
                    Diagnostics& report);

/// A half turn about z: what RAS is to LPS.
Aabb half_turned(const Aabb& box);

/// Whether boxes that do not meet would after a half turn of one of them.
bool meet_after_half_turn_only(const Aabb& a, const Aabb& b);

/// Warns where points of the scenario (`key`) lie outside the mesh, and would lie in its box after a half turn.
void warn_of_half_turn(const std::vector<Vec3>& points_mm, const std::string& key, const Aabb& mesh_mm,
                       Diagnostics& report);

}  // namespace reamsim
