#pragma once

#include <array>
#include <vector>

#include "render/gl/camera.h"
#include "render/surface/solid_field.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// The bone where a plane cuts it, as a picture that lies in the plane.
struct CutFace {
  std::array<Vec3, 4> corners_mm;  ///< in B: of texture (0,0), (1,0), (1,1), (0,1)
  int width = 0;
  int height = 0;
  /// Two per place: density of what is left (g/cm³); bone fraction − ½, smoothed as the surface is.
  std::vector<float> texels;
};

/// Samples the plane of `camera` wherever the picture shows it and there may be bone, one texel per pixel but no finer
/// than a quarter of a voxel. Empty (width 0) when the plane misses the bone.
CutFace sample_cut_face(const Voxmap& voxmap, const FillBricks& fill, const SolidField& field, const Camera& camera);

}  // namespace reamsim
