// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/sphere_scene.h"

#include <algorithm>
#include <cmath>

#include "sim/bench/poses.h"
#include "sim/bone/voxmap/sample_voxels.h"
#include "sim/tool/profile.h"

namespace reamsim::bench::sphere {

namespace {

constexpr double kWidthMm = 30;            // of the cap
constexpr double kSpacingVoxels = 0.4721;  // what `reamsim run` chooses

}  // namespace

FilledVoxmap block(double voxel_mm) {
  const Vec3 size_mm(kWidthMm + 4, kWidthMm + 4, kDepthMm + 2);
  VoxelGrid grid;
  grid.voxel_mm = voxel_mm;
  for (int i = 0; i < 3; ++i) grid.dims[i] = 8 * static_cast<int>(std::ceil(size_mm[i] / voxel_mm / 8));
  const Vec3 extent = voxel_mm * grid.dims.cast<double>();
  grid.origin_mm = {-extent.x() / 2 + 0.37 * voxel_mm, -extent.y() / 2 + 0.21 * voxel_mm, -extent.z()};
  FilledVoxmap voxmap(grid);
  const std::uint8_t grade = DensityMapping::grade_from_density(1.8);
  GradeBricks::Brick brick;
  brick.fill(grade);
  voxmap.grade = sample_bricks(grid.dims, [&](const Vec3i&, GradeBricks::Brick& out) {
    out = brick;
    return true;
  });
  voxmap.frame = "phantom";
  return voxmap;
}

Tool cap(double voxel_mm) {
  constexpr int kSteps = 64;  // exact erosion takes the arc through the vertices
  Tool tool;
  const double rim = std::asin(kWidthMm / 2 / kRadiusMm);
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = rim * i / kSteps;
    tool.profile.points.emplace_back(kRadiusMm * std::sin(angle), kRadiusMm * (1 - std::cos(angle)));
  }
  tool.profile.points.emplace_back(kWidthMm / 2, 8);
  tool.profile.points.emplace_back(0, 8);
  const int resolution = static_cast<int>(std::ceil(kWidthMm / (kSpacingVoxels * voxel_mm))) + 1;
  tool.mesh = revolve(tool.profile, segments_for_sagitta(kWidthMm / 2, 0.02 * kSpacingVoxels * voxel_mm));
  tool.shell = voxelize_surface(tool.mesh, std::min(resolution, 1024));
  tool.bounds = tool.mesh.bounds();
  tool.reach_mm = std::hypot(kWidthMm / 2, 8.0) + tool.shell.cell_mm;
  return tool;
}

Substep down_to(double depth_mm, std::int64_t number) {
  ToolPose pose;
  pose.position_mm = {0, 0, -depth_mm};
  pose.spin_rpm = 250;
  Substep frame = substep_at(pose);
  frame.origin_velocity_mm_s = {0, 0, -kSphereFeedMmS};
  frame.duration_s = kSphereFrameS;
  frame.frame = number;
  return frame;
}

}  // namespace reamsim::bench::sphere
