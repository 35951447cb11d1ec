// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <random>

#include "sim/record/recorder.h"
#include "sim/run/simulation.h"
#include "sim/tool/profile.h"

namespace reamsim::test {

/// A tool made in memory from its profile.
inline Tool make_tool(const Profile& profile, int resolution) {
  Tool tool;
  tool.profile = profile;
  tool.mesh = revolve(profile, 96);
  tool.shell = voxelize_surface(tool.mesh, resolution);
  tool.bounds = tool.mesh.bounds();
  for (const Vec3& v : tool.mesh.vertices) tool.reach_mm = std::max(tool.reach_mm, v.norm());
  return tool;
}

/// A spherical cap of radius of curvature `radius`, `width` wide and `height` tall, bored to radius `bore`: the shape
/// of the convex reamer's head, apex at the origin. `bore` 0: no bore.
inline Profile cap_profile(double radius, double width, double height, double bore) {
  const auto z = [&](double r) { return radius - std::sqrt(radius * radius - r * r); };
  const double half = width / 2;
  Profile profile;
  constexpr int kSteps = 48;
  for (int i = 0; i <= kSteps; ++i) {
    const double r = bore + (half - bore) * i / kSteps;
    profile.points.emplace_back(r, z(r));
  }
  profile.points.emplace_back(half, height);
  profile.points.emplace_back(bore, height);
  return profile;
}

/// A block of uniform density whose top face is z = 0.
inline FilledVoxmap block(const Vec3& size_mm, double voxel_mm, double density) {
  VoxelGrid grid;
  grid.voxel_mm = voxel_mm;
  grid.dims = (size_mm / voxel_mm).array().round().cast<int>();
  grid.origin_mm = {-size_mm.x() / 2, -size_mm.y() / 2, -size_mm.z()};
  FilledVoxmap voxmap(grid);
  const std::uint8_t grade = DensityMapping::grade_from_density(density);
  for (std::int64_t e = 0; e < grid.size(); ++e) voxmap.grade.set(grid.coord(e), grade);
  return voxmap;
}

/// One voxel, the whole lattice.
inline FilledVoxmap one_voxel(double voxel_mm, const Vec3& origin_mm, std::uint8_t grade) {
  FilledVoxmap voxmap(VoxelGrid{{1, 1, 1}, voxel_mm, origin_mm});
  voxmap.grade.set({0, 0, 0}, grade);
  return voxmap;
}

/// Bone with holes and every density, from a seed: nothing about it is regular.
inline FilledVoxmap random_bone(const Vec3i& dims, double voxel_mm, unsigned seed) {
  VoxelGrid grid{dims, voxel_mm, {-3.1, -2.7, -1.9}};
  FilledVoxmap voxmap(grid);
  std::mt19937 random(seed);
  for (std::int64_t e = 0; e < grid.size(); ++e) {
    const auto draw = static_cast<unsigned>(random() % 400);
    voxmap.grade.set(grid.coord(e), static_cast<std::uint8_t>(draw < 251 ? draw : 0));
  }
  return voxmap;
}

/// A straight path at constant spin.
inline Motion straight(const Vec3& from, const Vec3& to, int frames, double rate_hz, double rpm,
                       const Quat& orientation = Quat::Identity()) {
  std::vector<ToolPose> poses;
  for (int k = 0; k <= frames; ++k) {
    ToolPose pose;
    pose.position_mm = from + (to - from) * (double(k) / frames);
    pose.orientation = orientation;
    pose.spin_rpm = rpm;
    pose.spin_angle_rad = 2 * M_PI * rpm / 60 * k / rate_hz;
    poses.push_back(pose);
  }
  return {rate_hz, std::move(poses)};
}

/// Scenario defaults for a scene made in memory.
inline Scenario quiet_scenario(const std::string& device) {
  Scenario scenario;
  scenario.name = "test";
  scenario.engine.device = device;
  scenario.cutting.erosion = ErosionMode::remove;
  scenario.render.every_frames = 1'000'000;
  return scenario;
}

}  // namespace reamsim::test
