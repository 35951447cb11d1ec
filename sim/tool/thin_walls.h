// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "sim/mesh/triangle_mesh.h"
#include "sim/tool/profile.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// The thinnest wall of a solid.
struct ThinWall {
  double thickness_mm = 0;
  Vec3 at_mm = Vec3::Zero();  ///< on the surface
};

/// The thinnest wall of a closed mesh that faces outwards, if it is thinner than `limit_mm`: the shortest distance
/// along inward normals, from surface points half the limit apart, to an opposite face.
std::optional<ThinWall> thinnest_wall(const TriangleMesh& mesh, double limit_mm);

/// The same for the solid of revolution of a profile; `at_mm` has y = 0.
std::optional<ThinWall> thinnest_wall(const Profile& profile, double limit_mm);

/// Tolerated error of the grid's volume relative to the mesh's; larger ones cause a warning.
inline constexpr double kGridVolumeTolerance = 5e-3;

/// Prepares a tool for `erosion: exact` at voxels of `voxel_mm`: warns of thin walls, and makes the distance grid of
/// resolved cutting edges (`spin: resolved`, and the mesh is no surface of revolution). Throws InputError where it
/// would need more than `memory_bytes`.
void prepare_clipping(Tool& tool, const ToolSettings& settings, double voxel_mm, double memory_bytes,
                      Diagnostics& report);

}  // namespace reamsim
