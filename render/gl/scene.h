#pragma once

#include <map>
#include <memory>
#include <optional>
#include <tuple>

#include "render/gl/camera.h"
#include "render/gl/cut_face.h"
#include "render/gl/gl_objects.h"
#include "render/gl/pixel_image.h"
#include "render/gl/tile_bounds.h"
#include "render/surface/bone_surface.h"
#include "render/surface/tool_surface.h"
#include "sim/scenario/choices.h"

namespace reamsim {

/// How edges are kept from being jagged: by four samples per pixel, or, at half the price, by smoothing them
/// afterwards.
enum class Antialiasing { multisample, fxaa };

/// One picture to be drawn.
struct DrawCall {
  Camera camera;
  double depth_max_mm = 1;                       ///< top of the depth colours
  double contour_mm = 1;                         ///< a line on the reamed face at every multiple of this depth
  double density_max_g_cm3 = 2;                  ///< top of the density colours
  std::optional<Rigid> bone_from_spinning_tool;  ///< without it there is no tool
  bool steel = false;                            ///< the tool as opaque brushed steel, not see-through
  const CutFace* cut_face = nullptr;             ///< where the camera cuts the bone open
  Background background = Background::studio;
  Eigen::Vector3f key_direction = Eigen::Vector3f::UnitZ();  ///< towards the main light, in the eye's axes; unit length
  int supersampling = 1;                                     ///< drawn so many times as wide and high, and averaged
  Antialiasing antialiasing = Antialiasing::multisample;
};

/// The meshes, shaders and lights. Its context must be current.
class Scene {
 public:
  /// Throws RunError when a shader does not compile.
  Scene(const Gl& gl, const ToolSurface& tool);
  ~Scene();

  /// Takes over those of the bone's tiles that are others than before.
  void set_bone(const std::vector<BoneSurface>& tiles, const std::vector<std::size_t>& changed);
  /// The picture without labels, of the camera's size. Throws RunError when that is too large.
  [[nodiscard]] PixelImage draw(const DrawCall& call);

 private:
  struct Programs;
  struct Tile {
    GlMesh mesh;
    TileBounds bounds;
  };

  void draw_background(Background background) const;
  void draw_bone(const DrawCall& call) const;
  void draw_cut_face(const DrawCall& call) const;
  void draw_tool(const DrawCall& call) const;
  void draw_see_through(const GlProgram& program, bool cut_open) const;

  const Gl& gl_;
  std::unique_ptr<Programs> programs_;
  std::map<std::tuple<int, int, bool>, GlTarget> targets_;  ///< by width, height and whether it is multisampled
  GlMesh tool_;
  std::vector<std::unique_ptr<Tile>> bone_;  ///< none where a tile is empty
  GlTexture depth_colors_;
  GlTexture density_colors_;
  GLuint empty_array_ = 0;
};

}  // namespace reamsim
