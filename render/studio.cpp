#include "render/studio.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "render/bone_state.h"
#include "render/context.h"
#include "render/fixed_text.h"
#include "render/results.h"
#include "render/scene.h"
#include "render/subject.h"
#include "render/unreamed_surface.h"
#include "sim/base/error.h"
#include "sim/record/snapshot.h"

namespace reamsim {
namespace {

/// How much closer closer_camera() is.
constexpr double kCloser = 0.86;
/// The least share of the run's greatest force that has an arrow.
constexpr double kLeastArrow = 0.01;

Rigid spinning(const ToolPose& pose) {
  // Positive spin turns about −z of T.
  return pose.bone_from_tool() * Eigen::AngleAxisd(-pose.spin_angle_rad, Vec3::UnitZ());
}

Background background_named(const std::string& name) {
  if (name == "white") return Background::white;
  return name == "transparent" ? Background::transparent : Background::studio;
}

/// The circle that the tool's widest point sweeps, in B.
std::vector<Vec3> widest_circle(const TriangleMesh& tool, const Rigid& bone_from_tool) {
  Vec3 widest = Vec3::Zero();
  for (const Vec3& v : tool.vertices) {
    if (v.head<2>().norm() > widest.head<2>().norm()) widest = v;
  }
  std::vector<Vec3> circle;
  constexpr int kPoints = 128;
  for (int i = 0; i < kPoints; ++i) {
    const double turn = 2 * std::numbers::pi * i / kPoints;
    const double radius = widest.head<2>().norm();
    circle.emplace_back(bone_from_tool * Vec3(radius * std::cos(turn), radius * std::sin(turn), widest.z()));
  }
  return circle;
}

}  // namespace

/// Everything that stands in the studio.
struct Studio::Set {
  Set(const FinishedRun& finished, const RenderSettings& wanted, double mean_travel_mm)
      : run(finished),
        settings(wanted),
        mean(mean_travel_mm > 0 ? "mean " : ""),
        results(run.results()),
        last_fill(results.voxmap.fill),
        subject(make_subject(results, run.unreamed())),
        state(results.voxmap, run.unreamed()),
        deepest_mm(state.tiles().deepest_mm()),
        density_scale(scale_up_to(DensityMapping::kMaxDensity_g_cm3)) {
    add_layer_means(results.log, mean_travel_mm);
    for (const ForceRow& row : results.log.rows) most_force_n = std::max(most_force_n, row.layer_force_n.norm());
  }

  ~Set() { results.voxmap.fill = std::move(last_fill); }
  Set(const Set&) = delete;
  Set& operator=(const Set&) = delete;

  FinishedRun run;
  RenderSettings settings;
  std::string mean;
  RunResults& results;
  FillBricks last_fill;
  Subject subject;
  BoneState state;
  double deepest_mm;
  double most_force_n = 0;
  std::unique_ptr<OffscreenContext> context;
  std::unique_ptr<Scene> scene;
  Scale depth_scale;
  /// The same for every bone, so that pictures of different bones compare.
  Scale density_scale;
};

Studio::Studio(const FinishedRun& run, const RenderSettings& settings, double mean_travel_mm, Report* report)
    : set_(std::make_unique<Set>(run, settings, mean_travel_mm)) {
  std::string fallback;
  set_->context = make_context(settings.context, fallback);
  if (!fallback.empty() && report != nullptr) report->warn(fallback);
  set_->scene = std::make_unique<Scene>(set_->context->gl(), make_tool_surface(set_->results.tool));
  std::vector<std::size_t> all(set_->state.tiles().surfaces().size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  set_->scene->set_bone(set_->state.tiles().surfaces(), all);
  set_->depth_scale = settings.depth_max_mm > 0 ? scale_exactly(settings.depth_max_mm) : scale_up_to(set_->deepest_mm);
}

Studio::~Studio() = default;

void Studio::rewind() {
  set_->state.rewind();
}

void Studio::advance_to(std::int64_t frame) {
  apply_snapshot(set_->run.dir(), frame, set_->results.voxmap.fill);
  const auto changed = set_->state.follow();
  set_->scene->set_bone(set_->state.tiles().surfaces(), changed);
}

Camera Studio::camera(const std::string& name, int width_px, int height_px) const {
  for (const UserCamera& own : set_->settings.user_cameras) {
    if (own.name == name) return make_user_camera(own, set_->subject, width_px, height_px);
  }
  return make_camera(name, set_->subject, width_px, height_px);
}

Camera Studio::closer_camera(const std::string& name, int width_px, int height_px) const {
  Camera out = camera(name, width_px, height_px);
  const auto is_it = [&](const UserCamera& own) { return own.name == name; };
  if (std::ranges::none_of(set_->settings.user_cameras, is_it)) out.mm_per_px *= kCloser;
  return out;
}

PixelImage Studio::photograph(const Camera& camera, const std::optional<Rigid>& tool) {
  return draw(camera, tool, false);
}

PixelImage Studio::film_frame(const Camera& camera, const std::optional<Rigid>& tool) {
  return draw(camera, tool, true);
}

PixelImage Studio::draw(const Camera& camera, const std::optional<Rigid>& tool, bool for_film) {
  Shot shot;
  shot.camera = camera;
  shot.depth_max_mm = set_->depth_scale.max;
  shot.contour_mm = set_->depth_scale.step;
  shot.density_max_g_cm3 = set_->density_scale.max;
  shot.bone_from_spinning_tool = tool;
  // Solid where it is cut open, as the bone is; other views show the face behind it unless the user wants steel.
  shot.steel = camera.cut_plane || set_->settings.tool_look == "steel";
  shot.background = background_named(set_->settings.background);
  shot.key_direction = set_->settings.light.normalized().cast<float>();
  shot.supersampling = set_->settings.supersampling;
  shot.edges = for_film ? Edges::smoothed : Edges::sampled;
  CutFace cut_face;
  if (camera.cut_plane) {
    cut_face = sample_cut_face(set_->results.voxmap, set_->state.field(), camera);
    shot.cut_face = &cut_face;
  }
  return set_->scene->draw(shot);
}

Labels Studio::labels(const Camera& camera, const std::optional<Rigid>& tool) const {
  Labels labels;
  labels.legends.push_back({"Reamed depth", "mm", depth_colors(), set_->depth_scale});
  if (camera.cut_plane) labels.legends.push_back({"Bone density", "g/cm³", density_colors(), set_->density_scale});
  if (set_->subject.anatomical) {
    labels.directions = {{"superior", set_->subject.superior}, {"lateral", set_->subject.outward}};
    if (set_->subject.anterior) labels.directions.emplace_back("anterior", *set_->subject.anterior);
  }
  if (tool && !camera.draws_tool) labels.outlines_mm.push_back(widest_circle(set_->results.tool, *tool));
  return labels;
}

std::optional<Rigid> Studio::tool_at(const ForceRow& row) const {
  if (!set_->settings.tool) return std::nullopt;
  return spinning(row.pose);
}

const ForceRow& Studio::row_of(std::int64_t frame) const {
  return set_->results.log.at(frame, set_->results.log_path);
}

const ForceLog& Studio::log() const {
  return set_->results.log;
}

const std::vector<std::int64_t>& Studio::frames() const {
  return set_->results.frames;
}

const Subject& Studio::subject() const {
  return set_->subject;
}

const RenderSettings& Studio::settings() const {
  return set_->settings;
}

double Studio::deepest_mm() const {
  return set_->deepest_mm;
}

std::optional<ForceArrow> Studio::force_arrow(const ForceRow& row) const {
  const double force_n = row.layer_force_n.norm();
  if (!set_->settings.force_arrow || force_n == 0 || force_n < kLeastArrow * set_->most_force_n) return std::nullopt;
  return ForceArrow{row.pose.position_mm, row.layer_force_n / set_->most_force_n, fixed_text(force_n, 1) + " N"};
}

const std::string& Studio::mean() const {
  return set_->mean;
}

}  // namespace reamsim
