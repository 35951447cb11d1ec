// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "render/gl/camera.h"
#include "render/gl/cut_face.h"
#include "render/gl/gl_objects.h"
#include "render/gl/pixel_image.h"
#include "render/surface/bone_surface.h"
#include "render/surface/surface_smoothing.h"
#include "sim/scenario/choices.h"

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

/// A closed contour line on a surface, B, mm.
struct SurfaceLine {
  std::vector<Vec3> points_mm;
  bool light = false;  ///< drawn white instead of nearly black
  double value = 0;    ///< of what is constant along it
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

/// Antialiasing by four samples per pixel, or, in half the time, by a filter on the finished picture.
enum class Antialiasing { multisample, fxaa };

/// The parameters of one picture.
struct DrawCall {
  Camera camera;
  double depth_max_mm = 1;                          ///< upper end of the depth colours
  double density_max_g_cm3 = 2;                     ///< upper end of the density colours
  std::optional<Rigid> bone_from_spinning_tool;     ///< without: no tool
  std::size_t tool = 0;                             ///< index of the scene's tool
  bool steel = false;                               ///< opaque brushed steel, as always in a section, not translucent
  const std::vector<SurfaceLine>* lines = nullptr;  ///< contour lines on the reamed face
  double line_width_px = 1;
  double line_opacity = 1;
  const CutFace* cut_face = nullptr;  ///< section of the bone by the camera's cut plane
  Background background = Background::studio;
  Eigen::Vector3f key_direction = Eigen::Vector3f::UnitZ();  ///< towards the key light, eye axes; unit length
  int supersampling = 1;                                     ///< factor along each axis
  Antialiasing antialiasing = Antialiasing::multisample;
};

/// Meshes, shaders and lights. Its context must be current.
class Scene {
 public:
  /// Throws RunError when a shader does not compile.
  Scene(const Gl& gl, const std::vector<ToolSurface>& tools);

  /// Uploads the changed tiles of the bone.
  void set_bone(const std::vector<BoneSurface>& tiles, const std::vector<std::size_t>& changed);
  /// The picture without labels, of the camera's size. Throws RunError when that is too large.
  [[nodiscard]] PixelImage draw(const DrawCall& call);

 private:
  struct Programs {
    explicit Programs(const Gl& gl);
    GlProgram background, bone, cut_face, line, tool, tool_cut;
  };
  struct Tile {
    GlMesh mesh;
    TileBounds bounds;
  };

  void draw_background(Background background) const;
  void draw_bone(const DrawCall& call) const;
  void draw_cut_face(const DrawCall& call) const;
  void draw_lines(const DrawCall& call) const;
  void draw_tool(const DrawCall& call) const;
  /// The cut through the tool; `program` draws the tool.
  void draw_tool_cut(const GlMesh& tool, const GlProgram& program, const DrawCall& call) const;
  void draw_translucent(const GlMesh& tool, const GlProgram& program) const;

  const Gl& gl_;
  Programs programs_;
  std::map<std::tuple<int, int, bool>, GlTarget> targets_;  ///< by width, height and whether it is multisampled
  std::deque<GlMesh> tools_;
  std::vector<std::unique_ptr<Tile>> bone_;  ///< null where a tile is empty
  GlTexture depth_colors_;
  GlTexture density_colors_;
  GlNames<1> empty_array_;  ///< for draws without vertex buffers
};

}  // namespace reamsim
