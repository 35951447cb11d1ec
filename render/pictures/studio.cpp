#include "render/pictures/studio.h"

#include <numeric>

#include "render/gl/context.h"
#include "render/gl/scene.h"
#include "render/surface/bone_state.h"
#include "sim/record/snapshot.h"

namespace reamsim {
namespace {

FillBricks first_fill(const RunPlan& plan) {
  FillBricks fill(plan.bone->grid.dims);
  apply_snapshot(plan.dir, plan.frames.front(), fill);
  return fill;
}

}  // namespace

/// Everything that stands in the studio.
struct Studio::Set {
  explicit Set(const RunView& view)
      : context(make_context(view.settings().context, warning)),
        state(*view.run().plan().bone, first_fill(view.run().plan()), view.run().unreamed()),
        scene(context->gl(), make_tool_surface(view.run().plan().tool)) {
    std::vector<std::size_t> all(state.tiles().surfaces().size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    scene.set_bone(state.tiles().surfaces(), all);
  }

  std::string warning;
  std::unique_ptr<OffscreenContext> context;
  BoneState state;
  Scene scene;
  std::size_t shown = 0;  ///< which of the plan's frames
};

Studio::Studio(const RunView& view) : view_(view), set_(std::make_unique<Set>(view)) {}

Studio::~Studio() = default;

void Studio::advance_to(std::int64_t frame) {
  const std::vector<std::int64_t>& frames = view_.frames();
  while (set_->shown + 1 < frames.size() && frames[set_->shown + 1] <= frame) {
    apply_snapshot(view_.run().plan().dir, frames[++set_->shown], set_->state.fill());
  }
  const auto changed = set_->state.follow();
  set_->scene.set_bone(set_->state.tiles().surfaces(), changed);
}

PixelImage Studio::photograph(const Camera& camera, const std::optional<Rigid>& tool) {
  return draw(camera, tool, false);
}

PixelImage Studio::film_frame(const Camera& camera, const std::optional<Rigid>& tool) {
  return draw(camera, tool, true);
}

PixelImage Studio::draw(const Camera& camera, const std::optional<Rigid>& tool, bool for_film) {
  const RenderSettings& settings = view_.settings();
  Shot shot;
  shot.camera = camera;
  shot.depth_max_mm = view_.depth_scale().max;
  shot.contour_mm = view_.depth_scale().step;
  shot.density_max_g_cm3 = view_.density_scale().max;
  shot.bone_from_spinning_tool = tool;
  // Solid where it is cut open, as the bone is; other views show the face behind it unless the user wants steel.
  shot.steel = camera.cut_plane || settings.tool_look == ToolLook::steel;
  shot.background = settings.background;
  shot.key_direction = settings.light.normalized().cast<float>();
  shot.supersampling = settings.supersampling;
  shot.edges = for_film ? Edges::smoothed : Edges::sampled;
  CutFace cut_face;
  if (camera.cut_plane) {
    cut_face = sample_cut_face(*view_.run().plan().bone, set_->state.fill(), set_->state.field(), camera);
    shot.cut_face = &cut_face;
  }
  return set_->scene.draw(shot);
}

double Studio::deepest_mm() const {
  return set_->state.tiles().deepest_mm();
}

const std::string& Studio::warning() const {
  return set_->warning;
}

}  // namespace reamsim
