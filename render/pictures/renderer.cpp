// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/renderer.h"

#include <algorithm>
#include <numeric>

#include "render/gl/context.h"
#include "render/gl/scene.h"
#include "render/pictures/surface_contours.h"
#include "render/surface/bone_tiles.h"
#include "sim/record/snapshot.h"

namespace reamsim {
namespace {

std::vector<ToolSurface> tool_surfaces(const RunInputs& run) {
  std::vector<ToolSurface> out;
  for (const ToolPass& pass : run.passes) out.push_back(make_tool_surface(pass.tool));
  return out;
}

}  // namespace

struct Renderer::State {
  explicit State(const RunView& view)
      : context(make_context(view.settings().context, warning)),
        fields(view.run().voxmap(), fill_at(view.run().inputs(), view.frames().front()), view.run().unreamed()),
        tiles(fields),
        scene(context->gl(), tool_surfaces(view.run().inputs())) {
    std::vector<std::size_t> all(tiles.surfaces().size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    scene.set_bone(tiles.surfaces(), all);
  }

  std::string warning;
  std::unique_ptr<OffscreenContext> context;
  BoneFields fields;
  BoneTiles tiles;
  Scene scene;
  std::size_t shown = 0;  ///< index of the snapshot
  std::vector<FaceContour> contours;
  std::vector<SurfaceLine> lines;  ///< the same, to draw
};

Renderer::Renderer(const RunView& view) : view_(view), state_(std::make_unique<State>(view)) {}

Renderer::~Renderer() = default;

void Renderer::advance_to(std::int64_t frame) {
  const std::vector<std::int64_t>& frames = view_.frames();
  while (state_->shown + 1 < frames.size() && frames[state_->shown + 1] <= frame) {
    apply_snapshot(view_.run().dir(), frames[++state_->shown], state_->fields.fill);
  }
  update_bone();
}

void Renderer::show(const FillBricks& fill) {
  state_->fields.fill = fill;
  update_bone();
}

void Renderer::update_bone() {
  const auto changed = state_->tiles.update(state_->fields, state_->fields.update());
  state_->scene.set_bone(state_->tiles.surfaces(), changed);
  update_contours();
}

void Renderer::update_contours() {
  const Scale& scale = view_.depth_scale();
  state_->contours =
      face_contours(state_->tiles.surfaces(), view_.map_from_bone(), view_.run().voxmap().grid.voxel_mm, scale);
  state_->lines.clear();
  for (const FaceContour& contour : state_->contours) {
    state_->lines.push_back({contour.points_mm, contour_style(contour.value_mm, scale).light});
  }
}

std::vector<SeenContour> Renderer::contours(const Camera& camera) const {
  return seen_contours(state_->contours, camera, state_->fields, view_.depth_scale());
}

PixelImage Renderer::render(const Camera& camera, const std::optional<PlacedTool>& tool, bool for_film) {
  const RenderSettings& settings = view_.settings();
  DrawCall call;
  call.camera = camera;
  call.depth_max_mm = view_.depth_scale().max;
  call.lines = &state_->lines;
  call.line_width_px = kContourWidth_px * std::max(0.6, camera.height_px / 1080.0);
  call.line_opacity = kContourOpacity;
  call.density_max_g_cm3 = view_.density_scale().max;
  if (tool) {
    call.bone_from_spinning_tool = tool->bone_from_tool;
    call.tool = tool->pass;
  }
  // Opaque in a section, like the bone. Other views show the face behind the tool, unless the user selects steel.
  call.steel = camera.cut_plane || settings.tool_material == ToolMaterial::steel;
  call.background = settings.background;
  call.key_direction = settings.light.normalized().cast<float>();
  call.supersampling = settings.supersampling;
  call.antialiasing = for_film ? Antialiasing::fxaa : Antialiasing::multisample;
  CutFace cut_face;
  if (camera.cut_plane) {
    cut_face = sample_cut_face(view_.run().voxmap(), state_->fields.fill, state_->fields.solid, view_.run().unreamed(),
                               camera);
    call.cut_face = &cut_face;
  }
  return state_->scene.draw(call);
}

double Renderer::deepest_mm() const {
  return state_->tiles.deepest_mm();
}

std::string Renderer::context() const {
  return state_->context->description();
}

const std::string& Renderer::warning() const {
  return state_->warning;
}

}  // namespace reamsim
