// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/run_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/record/snapshot.h"
#include "sim/scene/contact_forecast.h"
#include "sim/tool/profile.h"

namespace reamsim {
namespace {

/// The circle swept by the tool's outermost point, in B.
std::vector<Vec3> widest_circle(const TriangleMesh& tool, const Rigid& bone_from_tool) {
  Vec3 widest = Vec3::Zero();
  for (const Vec3& v : tool.vertices) {
    if (v.head<2>().norm() > widest.head<2>().norm()) widest = v;
  }
  std::vector<Vec3> circle;
  constexpr int kPoints = 128;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPoints;
    const double radius = widest.head<2>().norm();
    circle.emplace_back(bone_from_tool * Vec3(radius * std::cos(angle), radius * std::sin(angle), widest.z()));
  }
  return circle;
}

/// Least fraction of the run's greatest force that is drawn as an arrow.
constexpr double kMinArrowFraction = 0.01;

/// The tool's path, with the frames of the run.
ToolPath path_of_pass(const ToolPass& pass) {
  std::vector<PathSample> path;
  for (std::size_t i = 0; i < pass.poses.size(); ++i) {
    path.push_back({pass.poses[i], static_cast<std::size_t>(pass.pose_frames[i])});
  }
  return {std::move(path), tool_reach_mm(pass.tool)};
}

/// Adds a pass after those so far.
void add_pass(const RunInputs& run, std::size_t index, PredictedRun& out) {
  const ToolPass& pass = run.passes[index];
  const Profile tool = envelope_of_revolution(pass.tool).profile;
  const auto contact = forecast_contact_frames(*run.voxmap, out.bone.fill, tool, path_of_pass(pass));
  if (contact) out.contact.push_back(*contact);
  PredictedBone bone = predict_swept_bone(*run.voxmap, out.bone.fill, tool, pass.poses, run.whole_voxels);
  if (!bone.touches) return;
  out.bone = std::move(bone);
  out.pass = index;
}

}  // namespace

Scale depth_scale(const RunData& run, double depth_max_mm) {
  return depth_max_mm > 0 ? scale_exactly(depth_max_mm) : scale_up_to(run.unreamed().deepest_mm());
}

RunView::RunView(const RunData& run, const RenderSettings& settings)
    : run_(run), settings_(settings), depth_scale_(reamsim::depth_scale(run, settings.depth_max_mm)) {}

Camera RunView::camera(const std::string& name, int width_px, int height_px) const {
  for (const UserCamera& own : settings_.user_cameras) {
    if (own.name == name) return make_user_camera(own, run_.target(), width_px, height_px);
  }
  return make_camera(from_name<CameraView>(name).value(), run_.target(), width_px, height_px);
}

std::optional<PlacedTool> RunView::tool_at(std::int64_t frame) const {
  if (!settings_.tool) return std::nullopt;
  const ToolPose& pose = run_.inputs().pose_at(frame);
  // A positive spin is about −z of T.
  const Rigid bone_from_tool = pose.bone_from_tool() * Eigen::AngleAxisd(-pose.spin_angle_rad, Vec3::UnitZ());
  return PlacedTool{bone_from_tool, run_.inputs().pass_at(frame)};
}

Rigid RunView::map_from_bone() const {
  const ViewTarget& target = run_.target();
  return (target.bone_from_glenoid ? *target.bone_from_glenoid : target.bone_from_tool).inverse();
}

Labels RunView::labels(const Camera& camera, const std::optional<PlacedTool>& tool) const {
  Labels labels;
  labels.legends.push_back({"Reamed depth", "mm", depth_colors(), depth_scale_});
  if (camera.cut_plane) labels.legends.push_back({"Bone density", "g/cm³", density_colors(), density_scale()});
  const ViewTarget& target = run_.target();
  if (target.anatomical) {
    labels.directions = {{"superior", target.superior}, {"lateral", target.outward}};
    if (target.anterior) labels.directions.emplace_back("anterior", *target.anterior);
  }
  if (tool && !camera.shows_tool) {
    labels.outlines_mm.push_back(widest_circle(run_.inputs().passes[tool->pass].tool, tool->bone_from_tool));
  }
  return labels;
}

Captions::Captions(ForceLog log, double mean_travel_mm, bool arrows)
    : log_(std::move(log)), mean_(mean_travel_mm > 0 ? "mean " : ""), arrows_(arrows) {
  add_layer_means(log_, mean_travel_mm);
  for (const ForceRow& row : log_.rows) {
    max_force_n_ = std::max(max_force_n_, row.layer_force_n.norm());
  }
}

Captions::Values Captions::at(const ForceRow& row) const {
  const bool several = log_.rows.back().pass > 1;
  Values out{{several ? "pass " + std::to_string(row.pass) + ", time" : "time", fixed_text(row.time_s, 3) + " s"},
             {"tool depth", depth_text(row.depth_mm)},
             {mean_ + "axial force", fixed_text(row.layer_axial_force_n, 1) + " N"},
             {mean_ + "spin torque", fixed_text(row.layer_spin_torque_nmm, 0) + " N·mm"},
             {"removed", fixed_text(row.removed_mm3, 1) + " mm³"}};
  if (row.push) out.insert(out.begin() + 2, {"feed rate", fixed_text(row.push->feed_mm_s, 2) + " mm/s"});
  return out;
}

Captions::Values Captions::after(double deepest_mm) const {
  const KeyResults run = key_results_of(log_, !mean_.empty());
  return {{KeyResults::kDepthName, run.depth_text() + " mm"},
          {run.force_name(), run.force_text() + " N"},
          {run.torque_name(), run.torque_text() + " N·mm"},
          {"removed", fixed_text(log_.rows.back().removed_mm3, 1) + " mm³"},
          {"greatest reamed depth", fixed_text(deepest_mm, 2) + " mm"}};
}

std::optional<ForceArrow> Captions::arrow(const ForceRow& row) const {
  const double force_n = row.layer_force_n.norm();
  if (!arrows_ || force_n == 0 || force_n < kMinArrowFraction * max_force_n_) return std::nullopt;
  // The resultant; a mean has only its axial part.
  const std::string name = mean_.empty() ? "resultant " : mean_ + "axial force ";
  return ForceArrow{row.pose.position_mm, row.layer_force_n / max_force_n_, name + fixed_text(force_n, 1) + " N"};
}

double tool_reach_mm(const TriangleMesh& tool) {
  double reach_mm = 0;
  for (const Vec3& v : tool.vertices) reach_mm = std::max(reach_mm, v.norm());
  return reach_mm;
}

PredictedRun predict_run(const RunInputs& run) {
  PredictedRun out{.bone = {.fill = run.fill, .deepest = run.passes.front().poses.front()}, .contact = {}};
  for (std::size_t i = 0; i < run.passes.size(); ++i) {
    try {
      add_pass(run, i, out);
    } catch (const InputError& error) {
      throw InputError({tool_path(run.dir, static_cast<int>(i) + 1), 0, 0}, "", error.what(),
                       "expected the tool of a run");
    }
  }
  return out;
}

}  // namespace reamsim
