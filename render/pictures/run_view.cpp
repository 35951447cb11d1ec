// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/run_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "render/surface/unreamed_surface.h"
#include "sim/base/error.h"
#include "sim/record/snapshot.h"
#include "sim/scene/contact_forecast.h"
#include "sim/tool/profile.h"

namespace reamsim {

namespace {

Rigid spinning(const ToolPose& pose) {
  // A positive spin is about −z of T.
  return pose.bone_from_tool() * Eigen::AngleAxisd(-pose.spin_angle_rad, Vec3::UnitZ());
}

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
  return PlacedTool{spinning(run_.inputs().pose_at(frame)), run_.inputs().pass_at(frame)};
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

namespace {

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
