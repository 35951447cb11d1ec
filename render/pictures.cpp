#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <future>
#include <memory>
#include <numbers>
#include <numeric>

#include "render/bone_state.h"
#include "render/context.h"
#include "render/fixed_text.h"
#include "render/overlay.h"
#include "render/render.h"
#include "render/results.h"
#include "render/scene.h"
#include "render/subject.h"
#include "sim/base/error.h"
#include "sim/record/snapshot.h"

namespace reamsim {
namespace {

Rigid spinning(const ToolPose& pose) {
  // Positive spin turns about −z of T.
  return pose.bone_from_tool() * Eigen::AngleAxisd(-pose.spin_angle_rad, Vec3::UnitZ());
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

/// Makes all pictures of one run.
class PictureMaker {
 public:
  PictureMaker(const std::string& dir, const RenderSettings& settings, double mean_travel_mm,
               const PictureProgress& progress)
      : dir_(dir),
        settings_(settings),
        mean_(mean_travel_mm > 0 ? "mean " : ""),
        progress_(progress),
        results_(read_results(dir)),
        unreamed_(results_.voxmap, results_.unreamed_fill),
        subject_(make_subject(results_, unreamed_)) {
    add_layer_means(results_.log, mean_travel_mm);
    for (const std::string& name : settings.cameras) {
      cameras_.push_back(make_camera(name, subject_, settings.width_px, settings.height_px));
    }
  }

  void run(Report* report) {
    std::string fallback;
    const auto context = make_context(settings_.context, fallback);
    if (!fallback.empty() && report != nullptr) report->warn(fallback);
    Scene scene(context->gl(), settings_.width_px, settings_.height_px, make_tool_surface(results_.tool));
    std::filesystem::create_directories(dir_ + "/frames");
    BoneState state(results_.voxmap, unreamed_);
    final_pictures(scene, state);
    frame_pictures(scene, state);
    finish_writing();
  }

 private:
  /// The last state first: it says how far the depth legend must go.
  void final_pictures(Scene& scene, const BoneState& state) {
    const double deepest_mm = state.tiles().deepest_mm();
    depth_scale_ = settings_.depth_max_mm > 0 ? scale_exactly(settings_.depth_max_mm) : scale_up_to(deepest_mm);
    std::vector<std::size_t> all(state.tiles().surfaces().size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    scene.set_bone(state.tiles().surfaces(), all);
    double most_axial_n = 0;
    double most_torque_nmm = 0;
    for (const ForceRow& row : results_.log.rows) {
      most_axial_n = std::max(most_axial_n, row.layer_axial_force_n);
      most_torque_nmm = std::max(most_torque_nmm, row.layer_spin_torque_nmm);
    }
    Labels labels = common_labels();
    labels.title = "After reaming";
    labels.values = {{"deepest", fixed_text(deepest_mm, 2) + " mm"},
                     {"removed", fixed_text(results_.log.rows.back().removed_mm3, 1) + " mm³"},
                     {"peak " + mean_ + "force", fixed_text(most_axial_n, 1) + " N"},
                     {"peak " + mean_ + "torque", fixed_text(most_torque_nmm, 0) + " N·mm"}};
    for (const Camera& camera : cameras_) {
      picture(scene, state, camera, labels, std::nullopt, dir_ + "/reamed" + suffix(camera) + ".png");
    }
  }

  void frame_pictures(Scene& scene, BoneState& state) {
    state.rewind();
    for (const std::int64_t frame : results_.frames) {
      const ForceRow& row = results_.log.at(frame, results_.log_path);
      apply_snapshot(dir_, frame, results_.voxmap.fill);
      const auto changed = state.follow();
      scene.set_bone(state.tiles().surfaces(), changed);
      Labels labels = common_labels();
      labels.values = {{"time", fixed_text(row.time_s, 3) + " s"},
                       {"depth", fixed_text(row.depth_mm, 2) + " mm"},
                       {mean_ + "axial force", fixed_text(row.layer_axial_force_n, 1) + " N"},
                       {mean_ + "torque", fixed_text(row.layer_spin_torque_nmm, 0) + " N·mm"},
                       {"removed", fixed_text(row.removed_mm3, 1) + " mm³"}};
      std::optional<Rigid> tool;
      if (settings_.tool) tool = spinning(row.pose);
      std::array<char, 32> name;
      std::snprintf(name.data(), name.size(), "%06lld", static_cast<long long>(frame));
      for (const Camera& camera : cameras_) {
        picture(scene, state, camera, labels, tool, dir_ + "/frames/" + name.data() + suffix(camera) + ".png");
      }
    }
  }

  void picture(Scene& scene, const BoneState& state, const Camera& camera, Labels labels,
               const std::optional<Rigid>& tool, const std::string& path) {
    Shot shot;
    shot.camera = camera;
    shot.depth_max_mm = depth_scale_.max;
    shot.contour_mm = depth_scale_.step;
    shot.density_max_g_cm3 = density_scale_.max;
    shot.bone_from_spinning_tool = tool;
    CutFace cut_face;
    if (camera.cut_plane) {
      cut_face = sample_cut_face(results_.voxmap, state.field(), camera);
      shot.cut_face = &cut_face;
      labels.legends.push_back({"Bone density", "g/cm³", density_colors(), density_scale_});
    }
    if (tool && !camera.draws_tool) labels.outlines_mm.push_back(widest_circle(results_.tool, *tool));
    std::vector<std::uint32_t> pixels = scene.draw(shot);
    draw_labels(pixels, camera, labels);
    finish_writing();
    writing_path_ = path;
    writing_ = std::async(std::launch::async, [path, camera, image = std::move(pixels)]() mutable {
      write_png(path, image, camera.width_px, camera.height_px);
    });
  }

  /// Waits for the picture that is being compressed while the next one is drawn; throws what writing it threw.
  void finish_writing() {
    if (!writing_.valid()) return;
    writing_.get();
    const int total = static_cast<int>(cameras_.size() * (results_.frames.size() + 1));
    if (progress_) progress_(++done_, total, writing_path_);
  }

  [[nodiscard]] Labels common_labels() const {
    Labels labels;
    labels.legends.push_back({"Reamed depth", "mm", depth_colors(), depth_scale_});
    if (subject_.anatomical) {
      labels.directions = {{"superior", subject_.superior}, {"lateral", subject_.outward}};
      if (subject_.anterior) labels.directions.emplace_back("anterior", *subject_.anterior);
    }
    return labels;
  }

  [[nodiscard]] std::string suffix(const Camera& camera) const {
    return &camera == &cameras_.front() ? std::string() : "_" + camera.name;
  }

  std::string dir_;
  RenderSettings settings_;
  std::string mean_;  ///< before the names of forces that are means
  PictureProgress progress_;
  RunResults results_;
  UnreamedSurface unreamed_;
  Subject subject_;
  std::vector<Camera> cameras_;
  Scale depth_scale_;
  /// The same for every bone, so that pictures of different bones compare.
  Scale density_scale_ = scale_up_to(DensityMapping::kMaxDensity_g_cm3);
  int done_ = 0;
  std::string writing_path_;
  std::future<void> writing_;
};

}  // namespace

void render_pictures(const std::string& dir, const RenderSettings& settings, double mean_travel_mm,
                     const PictureProgress& progress, Report* report) {
  if (settings.cameras.empty()) {
    throw InputError({}, "render.cameras", "found none", "expected at least one camera");
  }
  try {
    PictureMaker(dir, settings, mean_travel_mm, progress).run(report);
  } catch (const std::filesystem::filesystem_error& error) {
    throw RunError(dir + ": " + error.code().message());
  } catch (const std::bad_alloc&) {
    throw RunError(dir + ": the pictures need more memory than there is");
  }
}

}  // namespace reamsim
