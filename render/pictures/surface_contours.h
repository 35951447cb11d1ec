// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "render/gl/camera.h"
#include "render/pictures/contour_labels.h"
#include "render/pictures/page_layout.h"
#include "render/surface/bone_surface.h"

namespace reamsim {

/// A contour line on the reamed face, in B, mm.
struct FaceContour {
  double value_mm = 0;
  std::vector<Vec3> points_mm;  ///< closed
};

/// The contours of the depth of a reamed surface at the ticks of a legend, by the same rules as those of the depth map:
/// the depth of the vertices is sampled on a raster across the axis +z of the map, from above, smoothed, and its lines
/// are laid on the face. `map_from_bone`: rigid; `spacing_mm` of the raster.
std::vector<FaceContour> face_contours(const std::vector<BoneSurface>& tiles, const Rigid& map_from_bone,
                                       double spacing_mm, const Scale& scale);

/// The contours as a camera sees them. `bone`: what may hide them.
std::vector<SeenContour> seen_contours(const std::vector<FaceContour>& contours, const Camera& camera,
                                       const BoneFields& bone, const Scale& scale);

}  // namespace reamsim
