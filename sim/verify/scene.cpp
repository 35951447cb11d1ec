// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/verify/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/tool/profile.h"
#include "sim/verify/closed_forms.h"

namespace reamsim::verify {

Profile ball_profile(double radius_mm, double edge_mm) {
  Profile profile;
  const int steps = static_cast<int>(std::ceil(radius_mm * std::numbers::pi / edge_mm));
  for (int i = 0; i <= steps; ++i) {
    const double angle = std::numbers::pi * i / steps;
    const bool pole = i == 0 || i == steps;
    profile.points.emplace_back(pole ? 0 : radius_mm * std::sin(angle), radius_mm - radius_mm * std::cos(angle));
  }
  return profile;
}

Profile convex_profile(double radius_mm, double outer_mm, double bore_mm, double height_mm, double edge_mm) {
  Profile profile;
  const double begin = std::asin(bore_mm / radius_mm), end = std::asin(outer_mm / radius_mm);
  const int steps = static_cast<int>(std::ceil(radius_mm * (end - begin) / edge_mm));
  for (int i = 0; i <= steps; ++i) {
    const double angle = begin + (end - begin) * i / steps;
    profile.points.emplace_back(radius_mm * std::sin(angle), radius_mm - radius_mm * std::cos(angle));
  }
  profile.points.emplace_back(outer_mm, height_mm);
  profile.points.emplace_back(bore_mm, height_mm);
  return profile;
}

Profile flat_profile(double outer_mm, double bore_mm, double height_mm) {
  return {{{bore_mm, 0}, {outer_mm, 0}, {outer_mm, height_mm}, {bore_mm, height_mm}}};
}

Tool make_tool(const Profile& profile, std::optional<double> shell_spacing_mm) {
  constexpr int kUnusedCells = 8;  // of a shell that exact erosion does not use
  Tool tool;
  tool.profile = profile;
  tool.bounds = profile.bounds();
  const double radius = tool.bounds.max.x(), low = tool.bounds.min.z(), high = tool.bounds.max.z();
  if (shell_spacing_mm) {
    const double longest = std::max(2 * radius, high - low);
    tool.mesh = revolve(profile, segments_for_sagitta(radius, 0.02 * *shell_spacing_mm));
    tool.shell = voxelize_surface(tool.mesh, static_cast<int>(std::ceil(longest / *shell_spacing_mm)) + 1);
  } else {
    tool.mesh = revolve({{{0, low}, {radius, low}, {radius, high}, {0, high}}}, 4 * kUnusedCells);
    tool.shell = voxelize_surface(tool.mesh, kUnusedCells);
  }
  for (const Vec2& rz : profile.points) tool.reach_mm = std::max(tool.reach_mm, rz.norm());
  return tool;
}

VoxelGrid block_grid(const Vec3& size_mm, double voxel_mm) {
  VoxelGrid grid;
  grid.voxel_mm = voxel_mm;
  for (int i = 0; i < 3; ++i) grid.dims[i] = 2 * static_cast<int>(std::ceil(size_mm[i] / (2 * voxel_mm) - 1e-9));
  const Vec3 extent_mm = voxel_mm * grid.dims.cast<double>();
  grid.origin_mm = {-extent_mm.x() / 2, -extent_mm.y() / 2, -extent_mm.z()};
  return grid;
}

FilledVoxmap block(const Vec3& size_mm, double voxel_mm, const DensityField& field) {
  return sample_phantom(block_grid(size_mm, voxel_mm), {}, field);
}

FilledVoxmap block(const Vec3& size_mm, double voxel_mm, double density_g_cm3) {
  return block(size_mm, voxel_mm, [=](const Vec3&) { return density_g_cm3; });
}

Quat rotation(const Vec3& axis, double degrees) {
  return Quat(Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis.normalized()));
}

Motion path(double rate_hz, const Vec3& from_mm, const std::vector<Leg>& legs) {
  std::vector<ToolPose> poses;
  ToolPose pose;
  pose.position_mm = from_mm;
  pose.orientation = legs.front().turned;
  pose.spin_rpm = legs.front().rpm;
  poses.push_back(pose);
  for (const Leg& leg : legs) {
    const ToolPose begin = poses.back();
    for (int k = 1; k <= leg.frames; ++k) {
      const double fraction = double(k) / leg.frames;
      pose.position_mm = begin.position_mm + fraction * (leg.to_mm - begin.position_mm);
      pose.orientation = begin.orientation.slerp(fraction, leg.turned);
      pose.spin_rpm = leg.rpm;
      pose.spin_angle_rad = begin.spin_angle_rad + angular_speed(leg.rpm) * k / rate_hz;
      poses.push_back(pose);
    }
  }
  return {rate_hz, std::move(poses)};
}

Vec3 ball_origin(const Vec3& center_mm, double radius_mm, const Quat& turned) {
  return center_mm - turned * Vec3(0, 0, radius_mm);
}

SimulationInput scene_of(FilledVoxmap bone, Tool tool, Motion motion, ErosionMode erosion) {
  SimulationInput scene;
  scene.scenario.name = "verification";
  scene.scenario.cutting = stated_cutting(erosion);
  scene.scenario.render.enabled = false;
  scene.scenario.render.every_frames = std::numeric_limits<int>::max();
  scene.bone.set_voxels(std::move(bone));
  scene.tool = std::move(tool);
  scene.motion = std::move(motion);
  return scene;
}

}  // namespace reamsim::verify
