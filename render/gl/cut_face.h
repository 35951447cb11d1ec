// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <vector>

#include "render/gl/camera.h"
#include "render/surface/bone_surface.h"

namespace reamsim {

/// The section of the bone by a plane, as a texture in the plane.
struct CutFace {
  std::array<Vec3, 4> corners_mm;  ///< in B: of texture (0,0), (1,0), (1,1), (0,1)
  int width = 0;
  int height = 0;
  /// Two channels: density of the remaining bone (g/cm³); smoothed bone fraction − ½.
  std::vector<float> texels;
};

/// Samples the cut plane of `camera` within the picture and the bone's box, one texel per pixel but not finer than a
/// quarter of a voxel. The boundary between the layers of a mesh bone is drawn at its depth below the unreamed surface,
/// without voxel steps. Empty (width 0) when the plane misses the bone.
CutFace sample_cut_face(const BoneFields& bone, const Camera& camera);

}  // namespace reamsim
