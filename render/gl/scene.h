// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <deque>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "render/gl/camera.h"
#include "render/gl/context.h"
#include "render/surface/bone_surface.h"

namespace reamsim {

/// Bounding box and normal cone of a part of the bone's surface, for culling.
struct TileBounds {
  Eigen::AlignedBox3d box_mm;        ///< in B
  Vec3 mean_normal = Vec3::UnitZ();  ///< of its triangles, outward
  double normal_cone_sine = 1;       ///< sine of the largest angle to a normal; 1: a right angle or more
};

TileBounds tile_bounds(const BoneSurface& surface);
/// False only if all of it is outside the camera's frustum, cut away, or, without a cut, faces away.
bool may_be_visible(const TileBounds& bounds, const Camera& camera);

/// A closed contour line on a surface, B, mm.
struct SurfaceLine {
  std::vector<Vec3> points_mm;
  bool light = false;  ///< drawn white instead of nearly black
  double value = 0;    ///< of what is constant along it
};

/// The section of the bone by a plane, as a texture in the plane.
struct CutFace {
  std::array<Vec3, 4> corners_mm;  ///< in B: of texture (0,0), (1,0), (1,1), (0,1)
  int width = 0;
  int height = 0;
  /// Two channels: density of the remaining bone (g/cm³); smoothed bone fraction − ½.
  std::vector<float> texels;
};

/// Samples the cut plane within the picture and the bone's box, one texel per pixel but at least a quarter of a voxel;
/// the boundary between the layers of a mesh bone at its depth, without voxel steps. Width 0: it misses the bone.
CutFace sample_cut_face(const BoneFields& bone, const Camera& camera);

/// Opacity and width of contour lines, in every picture; the width holds for a picture 1080 high.
constexpr double kContourOpacity = 0.75;
constexpr double kContourWidth_px = 2.2;

/// The parameters of one picture. A section draws the tool as opaque steel, like the bone.
struct DrawCall {
  const Camera& camera;
  const RenderSettings& settings;
  double depth_max_mm;       ///< upper end of the depth colours
  double density_max_g_cm3;  ///< upper end of the density colours
  const std::vector<SurfaceLine>& lines;
  std::optional<PlacedTool> tool{};
  CutFace cut_face{};  ///< section of the bone by the camera's cut plane
  /// Antialiasing by a filter on the finished picture, in half the time of four samples per pixel.
  bool filtered = false;
};

/// Meshes, shaders and lights. Its context must be current.
class Scene {
 public:
  /// Throws RunError when a shader does not compile.
  explicit Scene(const Gl& gl);

  /// The tool of the next pass.
  void add_tool(const ToolSurface& tool);
  /// Uploads the changed tiles of the bone.
  void set_bone(const BoneTiles::Surfaces& tiles, const std::vector<std::size_t>& changed);
  /// The picture without labels, of the camera's size. Throws RunError when that is too large.
  [[nodiscard]] PixelImage draw(const DrawCall& call);

 private:
  struct Tile {
    Tile(const Gl& gl, const BoneSurface& surface)
        : mesh(gl, surface.vertices, BoneSurface::kAttributeSizes, surface.indices), bounds(tile_bounds(surface)) {}

    GlMesh mesh;
    TileBounds bounds;
  };

  void draw_background(Background background) const;
  void draw_bone(const DrawCall& call) const;
  void draw_cut_face(const DrawCall& call) const;
  void draw_lines(const DrawCall& call) const;
  void draw_tool(const DrawCall& call) const;
  // With the program of the tool in use.
  void draw_tool_cut(const GlMesh& tool, const DrawCall& call) const;
  void draw_translucent(const GlMesh& tool) const;

  const Gl& gl_;
  GlProgram background_program_, bone_program_, cut_face_program_, line_program_, tool_program_, tool_cut_program_;
  std::map<std::tuple<int, int, bool>, GlTarget> targets_;  ///< by width, height and whether it is multisampled
  std::deque<GlMesh> tools_;
  std::map<std::size_t, Tile> bone_;  ///< those that are not empty
  GlTexture depth_colors_;
  GlTexture density_colors_;
  GlNames<1> empty_array_;  ///< for draws without vertex buffers
};

}  // namespace reamsim
