#pragma once

#include "render/gl/camera.h"
#include "render/surface/bone_surface.h"

namespace reamsim {

/// Where a part of the bone's surface lies and which way it faces: enough to leave it out of pictures that it is not
/// in.
struct TileBounds {
  Eigen::AlignedBox3d box_mm;   ///< in B
  Vec3 mean_normal = Vec3::UnitZ();  ///< the middle of its triangles' outward normals
  double normal_cone_sine = 1;  ///< sine of the largest angle from there to a normal; 1: a right angle or more
};

/// Bounds of a surface that has triangles.
TileBounds tile_bounds(const BoneSurface& surface);

/// Can the camera see any of it? False only where all of it lies beside the picture or behind the cut, or, without a
/// cut, faces away.
bool may_be_visible(const TileBounds& bounds, const Camera& camera);

}  // namespace reamsim
