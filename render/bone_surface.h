#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/ambient.h"
#include "render/solid_field.h"
#include "render/unreamed_surface.h"

namespace reamsim {

/// The bone as triangles for the graphics library.
struct BoneSurface {
  /// Numbers per vertex: position in B (mm), outward normal, and (depth below the unreamed surface in mm, how surely
  /// material is gone here 0…1, density in g/cm³, openness 0…1).
  static constexpr std::array kGroups{3, 3, 4};
  static constexpr std::size_t kStride = 10;

  std::vector<float> vertices;
  std::vector<std::uint32_t> indices;
  double deepest_mm = 0;  ///< of the reamed vertices; 0 when nothing is reamed
};

/// Meshes the bone as it is now and dresses every vertex.
BoneSurface make_bone_surface(const Voxmap& voxmap, const SolidField& field, const AmbientLight& ambient,
                              const UnreamedSurface& unreamed);

}  // namespace reamsim
