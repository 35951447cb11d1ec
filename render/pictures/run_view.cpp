// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/run_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/surface/unreamed_surface.h"

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

}  // namespace reamsim
