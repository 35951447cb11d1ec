// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/surface/solid_field.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// A colour map: sRGB colours 0…1 at equal steps from 0 to 1, interpolated linearly.
struct ColorMap {
  std::span<const Eigen::Vector3f> stops;

  [[nodiscard]] Eigen::Vector3f at(double x) const {
    const double position = std::clamp(x, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
    const auto lower = std::min(static_cast<std::size_t>(position), stops.size() - 2);
    const auto fraction = static_cast<float>(position - static_cast<double>(lower));
    return (1 - fraction) * stops[lower] + fraction * stops[lower + 1];
  }
};

/// Depth: viridis (van der Walt and Smith 2015, matplotlib, CC0) at eleven points, safe for colour-blind readers.
inline ColorMap depth_colors() {
  using Color = Eigen::Vector3f;
  static const std::array<Color, 11> kViridis{
      Color{0.267F, 0.005F, 0.329F}, Color{0.283F, 0.141F, 0.458F}, Color{0.254F, 0.265F, 0.530F},
      Color{0.207F, 0.372F, 0.553F}, Color{0.164F, 0.471F, 0.558F}, Color{0.128F, 0.567F, 0.551F},
      Color{0.135F, 0.659F, 0.518F}, Color{0.267F, 0.749F, 0.441F}, Color{0.478F, 0.821F, 0.318F},
      Color{0.741F, 0.873F, 0.150F}, Color{0.993F, 0.906F, 0.144F}};
  return {kViridis};
}

/// Density: red-brown over tan to ivory, like cut bone, ever lighter, fastest for trabecular bone; none a depth colour.
inline ColorMap density_colors() {
  using Color = Eigen::Vector3f;
  static const std::array<Color, 9> kCutBone{
      Color{0.16F, 0.04F, 0.05F}, Color{0.36F, 0.11F, 0.09F}, Color{0.52F, 0.22F, 0.15F},
      Color{0.65F, 0.34F, 0.22F}, Color{0.75F, 0.47F, 0.31F}, Color{0.83F, 0.60F, 0.42F},
      Color{0.89F, 0.73F, 0.56F}, Color{0.95F, 0.86F, 0.73F}, Color{1.00F, 0.98F, 0.92F}};
  return {kCutBone};
}

/// Ambient occlusion of surface points from the bone fraction in a hierarchy of cells, independent of the view.
class AmbientOcclusion {
 public:
  explicit AmbientOcclusion(const Occupancy& occupancy);

  void update(const Occupancy& occupancy, const std::vector<Vec3i>& bricks);

  /// Ambient accessibility: 1 unoccluded, 0 fully occluded. `point` in voxel index space; unit `normal`.
  [[nodiscard]] float accessibility(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;
  /// Bone farther than this from a point does not affect it.
  [[nodiscard]] double reach_voxels() const;

 private:
  /// Cells of `cell_voxels`³ voxels.
  struct Level {
    int cell_voxels;
    BrickLattice cells;
    std::vector<float> fractions;
    /// The fraction of a cell; 0 outside.
    [[nodiscard]] float get(const Vec3i& cell) const;
    /// Trilinear interpolation, voxel index space.
    [[nodiscard]] float sample(const Eigen::Vector3f& point) const;
  };

  /// Level and distance (voxels) at which a distance is sampled.
  struct Probe {
    std::size_t level;
    float offset, weight;
  };

  void average_brick(const Occupancy& occupancy, const Vec3i& brick);
  void average_coarse();

  std::vector<Level> levels_;
  std::vector<Probe> probes_;
};

/// The bone as a triangle mesh for OpenGL.
struct BoneSurface {
  /// Floats per vertex: position in B (mm), outward normal, and (depth below the unreamed surface in mm; 0…1, above ½
  /// on the reamed face; density in g/cm³; ambient accessibility 0…1).
  static constexpr std::array kAttributeSizes{3, 3, 4};
  static constexpr std::size_t kStride = 10;
  static constexpr std::size_t kNormal = 3, kDepth = 6, kReamed = 7, kDensity = 8, kAccessibility = 9;  ///< offsets

  [[nodiscard]] std::size_t count() const { return vertices.size() / kStride; }
  [[nodiscard]] auto position_mm(std::size_t i) const {
    return Eigen::Map<const Eigen::Vector3f>(vertices.data() + i * kStride);
  }

  std::vector<float> vertices;
  std::vector<std::uint32_t> indices;
  double deepest_mm = 0;  ///< of the reamed vertices, before smoothing; 0 when nothing is reamed
};

/// The tool as a triangle mesh for OpenGL.
struct ToolSurface {
  /// Floats per vertex: position in T (mm), outward normal.
  static constexpr std::array kAttributeSizes{3, 3};
  static constexpr std::size_t kStride = 6;

  std::vector<float> vertices;
  std::vector<std::uint32_t> indices;
};

/// Each corner gets the mean normal of adjacent triangles within the crease angle, so that cutting edges stay sharp.
ToolSurface make_tool_surface(const TriangleMesh& mesh);

/// The current bone and the fields derived from its fill, from which its surface is extracted.
struct BoneFields {
  BoneFields(const Voxmap& bone, FillBricks fill_now, const UnreamedSurface& unreamed_surface);
  BoneFields(const BoneFields&) = delete;
  BoneFields& operator=(const BoneFields&) = delete;

  /// Updates the fields after changes of `fill`. Returns the changed bricks.
  std::vector<Vec3i> update();

  const Voxmap& voxmap;
  FillBricks fill;
  const UnreamedSurface& unreamed;
  Occupancy occupancy;
  SolidField solid;
  AmbientOcclusion ambient;
};

/// The bone's surface in tiles of the lattice, so that only tiles near changed bone are meshed again. Together they are
/// the whole surface: neighbouring tiles mesh what crosses their border alike.
class BoneTiles {
 public:
  static constexpr int kSideBricks = 4;
  using Surfaces = std::vector<std::shared_ptr<const BoneSurface>>;  ///< shared by copies

  explicit BoneTiles(const BoneFields& fields);

  /// Updates the tiles after `bricks` of the fields have changed. Returns the changed tiles in ascending order.
  std::vector<std::size_t> update(const BoneFields& fields, const std::vector<Vec3i>& bricks);

  /// One per tile; most are empty.
  [[nodiscard]] const Surfaces& surfaces() const { return surfaces_; }
  /// The tiles as one surface; vertices of neighbours at the same place, to 0.001 mm, are one.
  [[nodiscard]] BoneSurface whole() const;
  /// Of the reamed vertices, mm; 0 when nothing is reamed.
  [[nodiscard]] double deepest_mm() const;

 private:
  /// Marks tiles at most `reach` bricks from any of `bricks`.
  [[nodiscard]] std::vector<bool> tiles_within(const std::vector<Vec3i>& bricks, int reach) const;
  void mesh(const BoneFields& fields, const std::vector<bool>& wanted);
  void mesh_together(const BoneFields& fields, const std::vector<Vec3i>& tiles);

  BrickLattice tiles_;  ///< the first tile begins one brick below the lattice, as the surface may
  Surfaces surfaces_;
};

/// The bone after reaming as one closed surface, for slicing, printing and viewers.
struct ReamedMesh {
  TriangleMesh mesh;                     ///< B, mm, counter-clockwise seen from outside
  std::vector<Eigen::Vector3f> normals;  ///< outward, unit length, per vertex
  std::vector<float> depth_mm;           ///< below the unreamed surface, per vertex; 0 where nothing was reamed
  std::vector<float> reamed;             ///< certainty that material was removed there, 0…1, per vertex
};

/// Meshes the level set `surface` of the VDB file `path`, with depths below `unreamed`, at the level near 0 at which it
/// encloses the volume of `bone`; closed where its lattice cuts the bone; with sharpen_edges() unless the erosion
/// removed `whole_voxels`. Throws InputError when the level set is missing or damaged.
ReamedMesh make_reamed_mesh(const std::string& path, const BoneView& bone, const UnreamedSurface& unreamed,
                            bool whole_voxels);

/// Moves the vertices of a smoothed mesh (B, mm) at reamed bone, and up to three vertices from it, to where columns of
/// voxels end and, at edges, to where the faces beside them meet: two quadratics, fitted to the surface up to 5.5
/// voxels away. Where these disagree with the fill, vertices stay; on rough bone, those at all edges. Turns no triangle
/// over.
void sharpen_edges(TriangleMesh& mesh, const BoneView& bone, const UnreamedSurface& unreamed);

/// Writes a binary glTF 2.0, not by assimp, which exports no _DEPTH_MM: one mesh in B, mm, with depth colours up to
/// `depth_max_mm`; a node turns +z of B up. Throws RunError when it cannot be written or exceeds the 4 GiB of GLB.
void write_glb(const std::string& path, const ReamedMesh& reamed, double depth_max_mm);

}  // namespace reamsim
