// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <vector>

#include "render/gl/camera.h"

namespace reamsim {

/// A closed line on a surface, B, mm.
struct SurfaceLine {
  std::vector<Vec3> points_mm;
  bool light = false;  ///< drawn white instead of nearly black
};

/// Lines as ribbons that face the viewer, with one width in the picture.
struct LineRibbons {
  /// Floats per vertex: position in B (mm), place across the ribbon (−1 … 1), brightness (0 or 1).
  static constexpr std::array kAttributeSizes{3, 2};
  std::vector<float> vertices;
  std::vector<std::uint32_t> indices;
};

/// Ribbons of this width in pixels, moved towards the viewer by `lift_mm`, against z-fighting with the surface.
LineRibbons make_line_ribbons(const std::vector<SurfaceLine>& lines, const Camera& camera, double width_px,
                              double lift_mm);

}  // namespace reamsim
