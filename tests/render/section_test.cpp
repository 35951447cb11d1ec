// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Sections through bone and tool: what lies in the cut plane is seen, without voxel steps.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <numbers>

#include "render/surface/solid_field.h"
#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/bone/voxmap/sample_voxels.h"
#include "tests/render/opened_run.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

constexpr double kBall_mm = 10;
constexpr double kCortex_mm = 2;
constexpr BoneLayers kLayers{kCortex_mm, 1.6, 0.4};

/// A ball about the origin in two layers, by voxel as a mesh bone has them.
FilledVoxmap layered_ball() {
  VoxelGrid grid;
  grid.voxel_mm = 0.5;
  grid.dims = Vec3i(46, 45, 47);
  grid.origin_mm = Vec3(-11.5, -11.2, -11.7);
  FilledVoxmap voxmap(grid);
  voxmap.layers = kLayers;
  const auto grade = [&](const Vec3i& voxel) {
    const bool cortical = grid.center_mm(voxel).norm() > kBall_mm - kCortex_mm;
    return DensityMapping::grade_from_density(cortical ? kLayers.cortical_g_cm3 : kLayers.trabecular_g_cm3);
  };
  for (int k = 0; k < grid.dims.z(); ++k) {
    for (int j = 0; j < grid.dims.y(); ++j) {
      for (int i = 0; i < grid.dims.x(); ++i) {
        const Vec3i voxel(i, j, k);
        if (grid.center_mm(voxel).norm() < kBall_mm) voxmap.grade.set(voxel, grade(voxel));
      }
    }
  }
  const auto outside = [](const Vec3& point) { return point.norm() - kBall_mm; };
  const auto sample = [&](const Vec3i& voxel, std::uint8_t) -> SurfaceVoxel {
    return {fraction_inside(outside, grid.center_mm(voxel), grid.voxel_mm), grade(voxel)};
  };
  set_partial_fill(sample, voxmap);
  return voxmap;
}

/// Root mean square of the distance of the boundary between the layers from its circle in the plane z = 0, mm.
double boundary_error_mm(const std::function<double(const Vec3&)>& density_at_mm) {
  double squares = 0;
  constexpr int kAngles = 720;
  for (int n = 0; n < kAngles; ++n) {
    const double angle = 2 * std::numbers::pi * n / kAngles;
    const Vec3 way(std::cos(angle), std::sin(angle), 0);
    double inner = kBall_mm - kCortex_mm - 1;
    double outer = inner + 2;
    for (int i = 0; i < 20; ++i) {
      const double middle = 0.5 * (inner + outer);
      (density_at_mm(middle * way) < 1 ? inner : outer) = middle;
    }
    squares += std::pow(inner - (kBall_mm - kCortex_mm), 2) / kAngles;
  }
  return std::sqrt(squares);
}

TEST(LayerBoundaryTest, TheCortexEndsOnACircleNotOnVoxels) {
  const FilledVoxmap voxmap = layered_ball();
  const VoxelGrid& grid = voxmap.grid;
  const UnreamedSurface unreamed(voxmap, voxmap.fill, voxmap.fill);
  const auto index = [&](const Vec3& mm) { return Vec3((mm - grid.origin_mm) / grid.voxel_mm - Vec3::Constant(0.5)); };
  const LayerBoundary boundary(voxmap, unreamed, index({0, 0, 0}), index({1, 0, 0}), index({0, 1, 0}));
  const double by_voxels_mm = boundary_error_mm(
      [&](const Vec3& mm) { return mean_density<double>(voxmap, index(mm), [](const Vec3i&) { return 1.0; }); });
  const double by_depth_mm = boundary_error_mm([&](const Vec3& mm) { return boundary.density_at(index(mm), 0.1); });
  std::cout << "off the circle: by voxels " << by_voxels_mm << " mm, by depth " << by_depth_mm << " mm\n";
  EXPECT_GT(by_voxels_mm, 0.1);
  EXPECT_LT(by_depth_mm, 0.03);
  EXPECT_TRUE(boundary.near(index({kBall_mm - kCortex_mm, 0, 0})));
  EXPECT_FALSE(boundary.near(index({1, 2, 0})));
  EXPECT_NEAR(boundary.density_at(index({3, 0, 0}), 0.1), kLayers.trabecular_g_cm3, 1e-9);
  EXPECT_NEAR(boundary.density_at(index({9.5, 0, 0}), 0.1), kLayers.cortical_g_cm3, 1e-9);
}

/// Where the ray of a pixel meets the cut plane of an orthographic camera, in B.
Vec3 in_cut_plane(const Camera& camera, int x, int y) {
  const Vec3 eye((x + 0.5 - 0.5 * camera.width_px) * camera.mm_per_px,
                 (0.5 * camera.height_px - y - 0.5) * camera.mm_per_px, 0);
  const Rigid bone_from_eye = camera.eye_from_bone.inverse();
  const Vec3 start = bone_from_eye * eye;
  const Vec3 way = bone_from_eye.linear().col(2);
  const Vec3 normal = camera.cut_plane->head<3>();
  return start - way * ((normal.dot(start) + (*camera.cut_plane)(3)) / normal.dot(way));
}

// Smoothing rounds the edges of the bone by a part of a voxel into the tool, where it stood in front of the far wall of
// the tool that was drawn as its cut.
TEST(Section, BoneDoesNotShowInFrontOfTheCutTool) {
  const test::TempDir dir;
  const FixtureTruth truth = write_results(dir.path(), {});
  RenderSettings settings;
  settings.width_px = 960;
  settings.height_px = 540;
  test::OpenedRun run(dir.path(), settings);
  run.renderer.advance_to(40);
  const Camera camera = run.camera("section");
  const PixelImage image = run.renderer.render(camera, run.view.tool_at(40));
  const Rigid tool_from_bone = run.run.inputs().pose_at(40).bone_from_tool().inverse();
  int cut = 0;
  int bone = 0;
  for (int y = 0; y < image.height_px; ++y) {
    for (int x = 0; x < image.width_px; ++x) {
      const Vec3 p = tool_from_bone * in_cut_plane(camera, x, y);
      constexpr double kInside_mm = 0.15;
      const double radius = p.head<2>().norm();
      const double below = (p - Vec3(0, 0, truth.tool_radius_mm)).norm();
      if (below > truth.tool_radius_mm - kInside_mm || radius > truth.head_radius_mm - kInside_mm || p.z() > 6)
        continue;
      ++cut;
      const std::uint32_t pixel = image.pixels[image.index(x, y)];
      const int red = static_cast<int>(pixel >> 16 & 255), green = static_cast<int>(pixel >> 8 & 255);
      const int blue = static_cast<int>(pixel & 255);
      bone += red < green && green < blue && blue - red < 50 && red > 90 ? 0 : 1;
    }
  }
  EXPECT_GT(cut, 5000);
  EXPECT_EQ(bone, 0) << "of " << cut << " pixels of cut steel";
}

}  // namespace
}  // namespace reamsim
