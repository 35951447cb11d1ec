// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/gl/scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace reamsim {
namespace embedded {
using Shader = const char* const;
extern Shader shader_lighting, shader_background, shader_bone, shader_cut_face, shader_line, shader_tool,
    shader_tool_cut;
}  // namespace embedded
namespace {

/// From this factor on supersampling needs no multisampling.
constexpr int kSupersamplingAlone = 3;
/// Depth offsets towards the viewer against z-fighting with the bone: of the tool, of the cut through it, which lies in
/// the plane of the bone's cut face, and of contour lines.
constexpr double kToolOffset_mm = 0.6, kToolCutOffset_mm = 0.05, kLineLift_mm = 0.35;
/// Bone behind a section fades by 1/e over 25 mm.
constexpr double kHaze_per_mm = 0.04;

GlProgram program_of(const Gl& gl, const char* name, const char* shaders) {
  const char* const lighting = embedded::shader_lighting;
  return {
      gl, name, {"#version 450 core\n#define VERTEX\n", lighting, shaders}, {"#version 450 core\n", lighting, shaders}};
}

GlTexture color_texture(const Gl& gl, const ColorMap& map) {
  std::vector<float> texels;
  for (const Eigen::Vector3f& stop : map.stops) texels.insert(texels.end(), stop.data(), stop.data() + 3);
  return {gl, static_cast<int>(map.stops.size()), 1, 3, texels};
}

/// The cut plane in local coordinates; without one, a plane that clips nothing.
Eigen::Vector4d local_plane(const Camera& camera, const Rigid& bone_from_local) {
  if (!camera.cut_plane) return {0, 0, 0, 1};
  return bone_from_local.matrix().transpose() * *camera.cut_plane;
}

/// Uses a program and sets the uniforms that several programs have; OpenGL ignores the others.
const GlProgram& use_program(const GlProgram& program, const DrawCall& call) {
  program.use();
  program.set("clip_from_bone", call.camera.clip_from_bone());
  program.set("cut_plane", local_plane(call.camera, Rigid::Identity()));
  program.set("key_direction", call.settings.light.normalized());
  program.set("samples_per_px", 1.0 * call.settings.supersampling);
  return program;
}

/// Closed lines as ribbons that face the viewer, with one width in the picture, moved towards the viewer against
/// z-fighting with the surface. Per vertex: position in B (mm); place across the ribbon (−1 … 1), brightness (0 or 1).
GlMesh line_ribbons(const Gl& gl, const std::vector<SurfaceLine>& lines, const Camera& camera, double width_px) {
  std::vector<float> vertices;
  std::vector<std::uint32_t> indices;
  const Rigid bone_from_eye = camera.eye_from_bone.inverse();
  for (const SurfaceLine& line : lines) {
    const std::size_t count = line.points_mm.size();
    const auto first = static_cast<std::uint32_t>(vertices.size() / 5);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 eye = camera.eye_from_bone * line.points_mm[i];
      const Vec3 before = camera.eye_from_bone * line.points_mm[(i + count - 1) % count];
      const Vec3 after = camera.eye_from_bone * line.points_mm[(i + 1) % count];
      const Vec3 view = camera.towards_viewer(eye);
      const Vec3 side = (after - before).cross(view).normalized();  // 0 where the line points at the viewer
      for (const double across : {-1.0, 1.0}) {
        const Vec3 corner =
            bone_from_eye *
            (eye + across * 0.5 * width_px * camera.mm_per_px * camera.depth_ratio(eye) * side + kLineLift_mm * view);
        for (const double value : corner) vertices.push_back(static_cast<float>(value));
        vertices.push_back(static_cast<float>(across));
        vertices.push_back(line.light ? 1.0F : 0.0F);
      }
      const auto a = static_cast<std::uint32_t>(2 * i), b = static_cast<std::uint32_t>(2 * ((i + 1) % count));
      for (const std::uint32_t corner : {a, a + 1, b, b, a + 1, b + 1}) indices.push_back(first + corner);
    }
  }
  return {gl, vertices, std::array{3, 2}, indices};
}

/// A triangle seen edge-on to within this sine counts as visible, because its corners are rounded to subpixels.
constexpr double kEdgeOnSine = 0.02;

/// Is the box outside one plane of the view frustum?
bool outside_frustum(const Eigen::AlignedBox3d& box_mm, const Camera& camera) {
  const Eigen::Matrix4d clip_from_bone = camera.clip_from_bone();
  Eigen::Array<double, 4, 8> corners;
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner = box_mm.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    corners.col(i) = clip_from_bone * corner.homogeneous();
  }
  for (int axis = 0; axis < 3; ++axis) {
    if ((corners.row(axis) > corners.row(3)).all() || (corners.row(axis) < -corners.row(3)).all()) return true;
  }
  return false;
}

bool faces_away(const TileBounds& bounds, const Camera& camera) {
  if (bounds.normal_cone_sine >= 1) return false;
  const double sine = bounds.normal_cone_sine + kEdgeOnSine;
  if (!camera.eye_mm) {
    const Vec3 towards_eye = camera.eye_from_bone.linear().transpose().col(2);
    return bounds.mean_normal.dot(towards_eye) < -sine;
  }
  const Vec3 eye = camera.eye_from_bone.inverse() * Vec3(0, 0, *camera.eye_mm);
  const Vec3 away = bounds.box_mm.center() - eye;
  // Over the bounding sphere of the box, the vector to the eye varies by at most the sphere's radius.
  return bounds.mean_normal.dot(away) > sine * away.norm() + bounds.box_mm.diagonal().norm() / 2;
}

}  // namespace

TileBounds tile_bounds(const BoneSurface& surface) {
  TileBounds out;
  std::vector<Vec3> normals;  // of the triangles that are not degenerate
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i + 2 < surface.indices.size(); i += 3) {
    std::array<Vec3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      out.box_mm.extend(corners[k] = surface.position_mm(surface.indices[i + k]).cast<double>());
    }
    const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    if (normal.squaredNorm() > 0) sum += normals.emplace_back(normal.normalized());
  }
  if (sum.norm() < 1e-9) return out;
  out.mean_normal = sum.normalized();
  double cosine = 1;
  for (const Vec3& normal : normals) cosine = std::min(cosine, normal.dot(out.mean_normal));
  if (cosine > 0) out.normal_cone_sine = std::sqrt(1 - cosine * cosine);
  return out;
}

bool may_be_visible(const TileBounds& bounds, const Camera& camera) {
  if (outside_frustum(bounds.box_mm, camera)) return false;
  if (!camera.cut_plane) return !faces_away(bounds, camera);
  const Vec3 normal = camera.cut_plane->head<3>(), half = bounds.box_mm.sizes() / 2;
  return normal.dot(bounds.box_mm.center()) + camera.cut_plane->w() + normal.cwiseAbs().dot(half) >= 0;
}

Scene::Scene(const Gl& gl)
    : gl_(gl),
      background_program_(program_of(gl, "background", embedded::shader_background)),
      bone_program_(program_of(gl, "bone", embedded::shader_bone)),
      cut_face_program_(program_of(gl, "cut_face", embedded::shader_cut_face)),
      line_program_(program_of(gl, "line", embedded::shader_line)),
      tool_program_(program_of(gl, "tool", embedded::shader_tool)),
      tool_cut_program_(program_of(gl, "tool_cut", embedded::shader_tool_cut)),
      depth_colors_(color_texture(gl, reamsim::depth_colors())),
      density_colors_(color_texture(gl, reamsim::density_colors())),
      empty_array_(gl.GenVertexArrays, gl.DeleteVertexArrays) {}

void Scene::add_tool(const ToolSurface& tool) {
  tools_.emplace_back(gl_, tool.vertices, ToolSurface::kAttributeSizes, tool.indices);
}

void Scene::set_bone(const BoneTiles::Surfaces& tiles, const std::vector<std::size_t>& changed) {
  for (const std::size_t tile : changed) {
    bone_.erase(tile);
    if (!tiles[tile]->indices.empty()) bone_.try_emplace(tile, gl_, *tiles[tile]);
  }
}

PixelImage Scene::draw(const DrawCall& call) {
  const int factor = call.settings.supersampling;
  const int width_px = factor * call.camera.width_px;
  const int height_px = factor * call.camera.height_px;
  const bool multisample = factor < kSupersamplingAlone && !call.filtered;
  const std::tuple size(width_px, height_px, multisample);
  // Multisampled targets take 32 bytes per pixel, and pictures of one size follow each other.
  if (!targets_.contains(size)) std::erase_if(targets_, [](const auto& target) { return std::get<2>(target.first); });
  const GlTarget& target = targets_.try_emplace(size, gl_, width_px, height_px, multisample).first->second;
  target.bind();
  gl_.Enable(GL_MULTISAMPLE);
  gl_.Enable(GL_CLIP_DISTANCE0);
  gl_.DepthMask(GL_TRUE);
  gl_.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  gl_.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  if (call.settings.background != Background::transparent) draw_background(call.settings.background);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.DepthFunc(GL_LEQUAL);
  draw_bone(call);
  if (call.cut_face.width > 0) draw_cut_face(call);
  if (!call.lines.empty()) draw_lines(call);
  if (call.tool && call.camera.shows_tool) draw_tool(call);
  gl_.check("drawing a picture");
  PixelImage image{width_px, height_px, target.read()};
  if (call.filtered) image = antialiased(image);
  return downsampled(std::move(image), factor);
}

void Scene::draw_background(Background background) const {
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Disable(GL_BLEND);
  gl_.Disable(GL_CULL_FACE);
  background_program_.use();
  background_program_.set("white", background == Background::white ? 1 : 0);
  gl_.BindVertexArray(empty_array_[0]);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

void Scene::draw_bone(const DrawCall& call) const {
  const GlProgram& program = use_program(bone_program_, call);
  program.set("eye_from_bone", call.camera.eye_from_bone.matrix());
  program.set("depth_max_mm", call.depth_max_mm);
  program.set("haze_per_mm", call.camera.cut_plane ? kHaze_per_mm : 0.0);
  program.set("depth_colors", 0);
  depth_colors_.bind(0);
  (call.camera.cut_plane ? gl_.Disable : gl_.Enable)(GL_CULL_FACE);
  gl_.CullFace(GL_BACK);
  // The nearest first, so that few hidden pixels are shaded.
  std::vector<std::pair<double, const Tile*>> visible;
  for (const auto& [index, tile] : bone_) {
    if (!may_be_visible(tile.bounds, call.camera)) continue;
    visible.emplace_back(-(call.camera.eye_from_bone * tile.bounds.box_mm.center()).z(), &tile);
  }
  std::ranges::stable_sort(visible, {}, &std::pair<double, const Tile*>::first);
  for (const auto& [away_mm, tile] : visible) tile->mesh.draw();
}

void Scene::draw_cut_face(const DrawCall& call) const {
  const CutFace& face = call.cut_face;
  const GlTexture texture(gl_, face.width, face.height, 2, face.texels);
  std::vector<float> vertices;
  constexpr std::array<float, 8> kTexCoords{0, 0, 1, 0, 1, 1, 0, 1};
  for (std::size_t i = 0; i < face.corners_mm.size(); ++i) {
    for (const double value : face.corners_mm[i]) vertices.push_back(static_cast<float>(value));
    vertices.insert(vertices.end(), {kTexCoords[2 * i], kTexCoords[2 * i + 1]});
  }
  const std::array<std::uint32_t, 6> indices{0, 1, 2, 0, 2, 3};
  const GlMesh quad(gl_, vertices, std::array{3, 2}, indices);
  const GlProgram& program = use_program(cut_face_program_, call);
  program.set("density_max_g_cm3", call.density_max_g_cm3);
  program.set("face", 0);
  program.set("density_colors", 1);
  texture.bind(0);
  density_colors_.bind(1);
  gl_.Disable(GL_CULL_FACE);
  gl_.Enable(GL_BLEND);
  quad.draw();
}

void Scene::draw_lines(const DrawCall& call) const {
  const double width_px = kContourWidth_px * std::max(0.6, call.camera.height_px / 1080.0);
  const GlMesh mesh = line_ribbons(gl_, call.lines, call.camera, width_px + 1);
  const GlProgram& program = use_program(line_program_, call);
  program.set("half_width_px", 0.5 * width_px);
  program.set("opacity", kContourOpacity);
  gl_.Disable(GL_CULL_FACE);
  gl_.Enable(GL_BLEND);
  gl_.DepthMask(GL_FALSE);
  mesh.draw();
  gl_.DepthMask(GL_TRUE);
}

void Scene::draw_tool(const DrawCall& call) const {
  const Rigid& bone_from_tool = call.tool->bone_from_tool;
  const bool cut_open = call.camera.cut_plane.has_value();
  const GlMesh& tool = tools_.at(call.tool->pass);
  const GlProgram& program = use_program(tool_program_, call);
  program.set("clip_from_tool", Eigen::Matrix4d(call.camera.clip_from_bone() * bone_from_tool.matrix()));
  program.set("eye_from_tool", (call.camera.eye_from_bone * bone_from_tool).matrix());
  program.set("cut_plane", local_plane(call.camera, bone_from_tool));
  program.set("depth_offset", kToolOffset_mm * call.camera.clip_depth_per_mm());
  // Views other than sections show the face behind the tool, unless the user selects steel.
  const bool steel = cut_open || call.settings.tool_material == ToolMaterial::steel;
  program.set("brushed", steel ? 1 : 0);
  if (!steel) return draw_translucent(tool);
  gl_.Disable(GL_BLEND);
  gl_.Disable(GL_CULL_FACE);
  gl_.DepthMask(GL_TRUE);
  if (cut_open) {
    draw_tool_cut(tool, call);
    gl_.Enable(GL_CULL_FACE);
    gl_.CullFace(GL_BACK);
  }
  program.use();
  tool.draw();
}

void Scene::draw_tool_cut(const GlMesh& tool, const DrawCall& call) const {
  // The plane is inside the tool where more of its back faces than of its front faces are behind the plane. The bone
  // does not hide them: it may reach into the tool by the part of a voxel that smoothing rounds its edges by.
  gl_.Enable(GL_STENCIL_TEST);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  gl_.StencilFunc(GL_ALWAYS, 0, 255);
  gl_.StencilOpSeparate(GL_FRONT, GL_KEEP, GL_KEEP, GL_DECR_WRAP);
  gl_.StencilOpSeparate(GL_BACK, GL_KEEP, GL_KEEP, GL_INCR_WRAP);
  tool.draw();
  gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl_.Enable(GL_DEPTH_TEST);
  gl_.StencilFunc(GL_NOTEQUAL, 0, 255);
  gl_.StencilOpSeparate(GL_FRONT_AND_BACK, GL_KEEP, GL_KEEP, GL_KEEP);
  const GlProgram& cut = use_program(tool_cut_program_, call);
  const Eigen::Matrix4d bone_from_clip = call.camera.clip_from_bone().inverse();
  cut.set("plane_in_clip", Eigen::Vector4d(bone_from_clip.transpose() * *call.camera.cut_plane));
  cut.set("depth_offset", kToolCutOffset_mm * call.camera.clip_depth_per_mm());
  gl_.BindVertexArray(empty_array_[0]);
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
  gl_.Disable(GL_STENCIL_TEST);
}

void Scene::draw_translucent(const GlMesh& tool) const {
  const GlProgram& program = tool_program_;
  gl_.Enable(GL_BLEND);
  gl_.Enable(GL_CULL_FACE);
  // First the back faces, faintly: the inside of the far walls.
  gl_.CullFace(GL_FRONT);
  gl_.DepthMask(GL_FALSE);
  program.set("opacity_facing", 0.10);
  program.set("opacity_edge", 0.45);
  tool.draw();
  // Then only the nearest layer: a depth pass, and colour where the depth is equal.
  gl_.CullFace(GL_BACK);
  gl_.DepthMask(GL_TRUE);
  gl_.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  tool.draw();
  gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  program.set("opacity_facing", 0.38);
  program.set("opacity_edge", 0.95);
  tool.draw();
}

}  // namespace reamsim
