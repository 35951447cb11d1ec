#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/surface/ambient_occlusion.h"
#include "render/surface/solid_field.h"
#include "render/surface/unreamed_surface.h"

namespace reamsim {

/// The bone as triangles for the graphics library.
struct BoneSurface {
  /// Numbers per vertex: position in B (mm), outward normal, and (depth below the unreamed surface in mm, how certain
  /// it is that material was removed here 0…1, density in g/cm³, ambient accessibility 0…1).
  static constexpr std::array kGroups{3, 3, 4};
  static constexpr std::size_t kStride = 10;

  std::vector<float> vertices;
  std::vector<std::uint32_t> indices;
  double deepest_mm = 0;  ///< at the reamed vertices, before depth is smoothed; 0 when nothing is reamed
};

/// What a surface is made from: the bone as it is now, and the fields that are derived from its fill.
struct BoneFields {
  BoneFields(const Voxmap& bone, FillBricks fill_now, const UnreamedSurface& unreamed_surface);
  BoneFields(const BoneFields&) = delete;
  BoneFields& operator=(const BoneFields&) = delete;

  /// Follows changes of `fill`. Returns the bricks that have changed.
  std::vector<Vec3i> update();

  const Voxmap& voxmap;
  FillBricks fill;
  const UnreamedSurface& unreamed;
  Occupancy occupancy;
  SolidField solid;
  AmbientOcclusion ambient;
};

/// Meshes the bone as it is now, with all attributes of its vertices.
BoneSurface make_bone_surface(const BoneFields& fields);

/// How many edges from a vertex another one can lie that still moves it.
constexpr int kAttributeReach = 6;
/// Makes the vertices of `iso`, where the field is zero, into those of a picture: moved by up to 0.4 voxel until they
/// fit their normals, with their reaming. Takes over the triangles as they are. What does not depend on neighbours is
/// left to add_density_and_ambient().
BoneSurface add_vertex_attributes(const IsoSurface& iso, const BoneFields& fields);
/// Gives every vertex its density and its ambient accessibility, and the surface its greatest depth.
void add_density_and_ambient(const BoneFields& fields, BoneSurface& surface);
/// Computes the ambient accessibility of every vertex again.
void update_ambient(const BoneFields& fields, BoneSurface& surface);

}  // namespace reamsim
