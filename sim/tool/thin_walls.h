#pragma once

#include <optional>

#include "sim/mesh/triangle_mesh.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// Where a solid is thinnest.
struct ThinWall {
  double thickness_mm = 0;
  Vec3 at_mm = Vec3::Zero();  ///< on the surface
};

/// Walls whose faces are closer to parallel than this count, rad: every sharp edge is as thin as one likes at its tip,
/// where a plane per voxel is in error by the square of the voxel only.
inline constexpr double kWallAngle = 0.5235987756;  // 30°

/// The thinnest wall of a closed mesh that faces outwards, if it is thinner than `limit_mm`: the shortest way along
/// inward normals from points of the surface, half the limit apart, to a face that looks the other way.
std::optional<ThinWall> thinnest_wall(const TriangleMesh& mesh, double limit_mm);

/// The same of a solid of revolution, by its profile; `at_mm` at y = 0.
std::optional<ThinWall> thinnest_wall(const Profile& profile, double limit_mm);

}  // namespace reamsim
