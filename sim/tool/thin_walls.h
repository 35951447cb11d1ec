// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "sim/mesh/triangle_mesh.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// The thinnest wall of a solid.
struct ThinWall {
  double thickness_mm = 0;
  Vec3 at_mm = Vec3::Zero();  ///< on the surface
};

/// Largest angle between the faces of a wall, rad. Sharp edges do not count: at their tip the error of one plane per
/// voxel is of the order of the square of the voxel.
inline constexpr double kWallAngle = 0.5235987756;  // 30°

/// The thinnest wall of a closed mesh that faces outwards, if it is thinner than `limit_mm`: the shortest distance
/// along inward normals, from surface points half the limit apart, to an opposite face.
std::optional<ThinWall> thinnest_wall(const TriangleMesh& mesh, double limit_mm);

/// The same for the solid of revolution of a profile; `at_mm` has y = 0.
std::optional<ThinWall> thinnest_wall(const Profile& profile, double limit_mm);

}  // namespace reamsim
