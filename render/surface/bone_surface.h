#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/surface/ambient.h"
#include "render/surface/solid_field.h"
#include "render/surface/unreamed_surface.h"

namespace reamsim {

/// The bone as triangles for the graphics library.
struct BoneSurface {
  /// Numbers per vertex: position in B (mm), outward normal, and (depth below the unreamed surface in mm, how surely
  /// material is gone here 0…1, density in g/cm³, openness 0…1).
  static constexpr std::array kGroups{3, 3, 4};
  static constexpr std::size_t kStride = 10;

  std::vector<float> vertices;
  std::vector<std::uint32_t> indices;
  double deepest_mm = 0;  ///< at the reamed vertices, before depth is evened out; 0 when nothing is reamed
};

/// What a surface is made from.
struct BoneLook {
  const Voxmap& voxmap;
  const SolidField& field;
  const AmbientLight& ambient;
  const UnreamedSurface& unreamed;
};

/// Meshes the bone as it is now and dresses every vertex.
BoneSurface make_bone_surface(const BoneLook& look);

/// How many edges from a vertex another one can lie that still moves it.
constexpr int kDressReach = 6;
/// Makes the vertices of `iso`, where the field is zero, into those of a picture: moved by up to 0.4 voxel until they
/// fit their normals, with their reaming. Takes over the triangles as they are. What no neighbour has a part in is left
/// to complete().
BoneSurface dress_surface(const IsoSurface& iso, const BoneLook& look);
/// Gives every vertex its density and its openness, and the surface its greatest depth.
void complete(const BoneLook& look, BoneSurface& surface);
/// Looks again how open the surroundings of its vertices are.
void renew_openness(const BoneLook& look, BoneSurface& surface);

}  // namespace reamsim
