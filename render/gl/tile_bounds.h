// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "render/gl/camera.h"
#include "render/surface/bone_surface.h"

namespace reamsim {

/// Bounding box and normal cone of a part of the bone's surface, for culling.
struct TileBounds {
  Eigen::AlignedBox3d box_mm;        ///< in B
  Vec3 mean_normal = Vec3::UnitZ();  ///< of its triangles, outward
  double normal_cone_sine = 1;       ///< sine of the largest angle to a normal; 1: a right angle or more
};

/// Bounds of a surface that has triangles.
TileBounds tile_bounds(const BoneSurface& surface);

/// Can the camera see any of it? False only if all of it is outside the frustum, cut away, or, without a cut, faces
/// away.
bool may_be_visible(const TileBounds& bounds, const Camera& camera);

}  // namespace reamsim
