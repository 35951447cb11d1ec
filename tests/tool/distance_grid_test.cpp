// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The distance grid of a tool whose teeth are resolved, and the walls that are too thin to be clipped.
#include <gtest/gtest.h>

#include <random>

#include "sim/base/error.h"
#include "sim/bone/voxmap/sparse_bricks.h"
#include "sim/tool/profile.h"
#include "sim/tool/tool.h"
#include "tests/support/gear_mesh.h"
#include "tests/support/mesh_shapes.h"

namespace reamsim::test {
namespace {

/// The sample at the lowest corner of a cell of the lattice.
const float* lowest_corner(const DistanceGrid& grid, const Vec3i& cell) {
  const Vec3i brick = cell / DistanceGrid::kSide, at = cell - DistanceGrid::kSide * brick;
  return grid.samples.data() + grid.slot_of_brick[BrickLattice{grid.bricks}.index(brick)] * DistanceGrid::kSamples +
         (at.x() + DistanceGrid::kRow * (at.y() + DistanceGrid::kRow * at.z()));
}

/// Trilinear in doubles, straight from the samples.
double distance_at(const DistanceGrid& grid, const Vec3& p) {
  const Vec3 at = (p - grid.origin_mm) / grid.spacing_mm;
  const Vec3 base = at.array().floor(), t = at - base;
  const float* lowest = lowest_corner(grid, base.cast<int>());
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const int x = i & 1, y = i >> 1 & 1, z = i >> 2;
    const double weight = (x ? t.x() : 1 - t.x()) * (y ? t.y() : 1 - t.y()) * (z ? t.z() : 1 - t.z());
    sum += weight * double{lowest[x + DistanceGrid::kRow * (y + DistanceGrid::kRow * z)]};
  }
  return sum;
}

Profile envelope(const TriangleMesh& mesh) {
  return envelope_of_revolution(mesh).profile;
}

TEST(DistanceGrid, IsThatOfASphere) {
  constexpr double kRadius = 5, kVoxel = 0.4;
  const TriangleMesh mesh = sphere_mesh({0, 0, kRadius}, kRadius, 6);
  const DistanceGrid grid = make_distance_grid(mesh, envelope(mesh), kVoxel);
  EXPECT_LE(grid.spacing_mm, 0.5 * kVoxel);
  constexpr unsigned kSeed = 5;
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 along = Vec3(gauss(random), gauss(random), gauss(random)).normalized();
    const double away = 0.95 * kVoxel * u(random);  // from there on, corners of its cell are beyond the band
    // A trilinear distance is off by up to an eighth of the curvatures times the spacing's square, 0.002 mm. Farther
    // from the surface OpenVDB measures from a triangle next to the nearest one at times.
    const double tolerance = std::abs(away) < grid.spacing_mm ? 0.003 : 0.5 * grid.spacing_mm;
    EXPECT_NEAR(distance_at(grid, Vec3(0, 0, kRadius) + (kRadius + away) * along), away, tolerance);
  }
  EXPECT_EQ(distance_at(grid, {0, 0, kRadius}), -double{static_cast<float>(grid.band_mm)}) << "deep inside";
  EXPECT_EQ(distance_at(grid, {kRadius, kRadius, 0}), double{static_cast<float>(grid.band_mm)}) << "far outside";
}

TEST(DistanceGrid, RisesByNoMoreThanTheWay) {
  // Many small triangles a cell, which OpenVDB takes the wrong ones of.
  const TriangleMesh mesh = sphere_mesh({0, 0, 5}, 5, 6);
  const DistanceGrid grid = make_distance_grid(mesh, envelope(mesh), 0.8);
  const double most = grid.spacing_mm * (1 + 1e-5);
  const Vec3i cells = DistanceGrid::kSide * grid.bricks;
  for (int z = 0; z < cells.z(); ++z)
    for (int y = 0; y < cells.y(); ++y)
      for (int x = 0; x < cells.x(); ++x) {
        const float* lowest = lowest_corner(grid, {x, y, z});
        for (const int step : {1, DistanceGrid::kRow, DistanceGrid::kRow * DistanceGrid::kRow})
          ASSERT_LE(std::abs(double{lowest[step]} - double{lowest[0]}), most) << x << ", " << y << ", " << z;
      }
}

TEST(DistanceGrid, VolumeConverges) {
  const TriangleMesh mesh = gear_mesh(6, 4, 6, 5);
  const Profile swept = envelope(mesh);
  const double at_1 = std::abs(make_distance_grid(mesh, swept, 1.0).volume_error());
  const double at_half = std::abs(make_distance_grid(mesh, swept, 0.5).volume_error());
  const double at_quarter = std::abs(make_distance_grid(mesh, swept, 0.25).volume_error());
  std::cout << "volume error at voxels of 1, 0.5, 0.25 mm: " << at_1 << ", " << at_half << ", " << at_quarter << '\n';
  EXPECT_LT(at_half, 0.4 * at_1);
  EXPECT_LT(at_quarter, 0.4 * at_half);
  EXPECT_LT(at_quarter, kGridVolumeTolerance);
}

TEST(DistanceGrid, TakesNoMoreThanPlanned) {
  for (const double voxel_mm : {1.0, 0.5, 0.25}) {
    for (const TriangleMesh& mesh : {gear_mesh(6, 4, 6, 5), sphere_mesh({0, 0, 5}, 5, 5)}) {
      const DistanceGridPlan plan = plan_distance_grid(mesh, voxel_mm);
      const auto bytes = static_cast<double>(make_distance_grid(mesh, envelope(mesh), voxel_mm).bytes());
      EXPECT_LE(bytes, plan.kept_bytes) << voxel_mm;
      EXPECT_GE(bytes, 0.3 * plan.kept_bytes) << voxel_mm;
    }
  }
}

Tool tool_of(const TriangleMesh& mesh, bool revolved = false) {
  Tool tool;
  tool.mesh = mesh;
  tool.profile = envelope(mesh);
  tool.revolved = revolved;
  return tool;
}

ToolSettings resolved() {
  ToolSettings settings;
  settings.spin = ToolSpin::resolved;
  return settings;
}

TEST(ClippedTool, SaysWhichVoxelsFit) {
  Tool tool = tool_of(gear_mesh(6, 4, 6, 5));
  Diagnostics report;
  try {
    prepare_clipping(tool, resolved(), 0.1, 1e6, report);
    FAIL() << "a grid of more than 1 MB in 1 MB";
  } catch (const InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("bone.voxel_mm: the distance grid needs "), std::string::npos) << text;
    EXPECT_NE(text.find("tool.spin: envelope"), std::string::npos) << text;
    const double fitting = std::stod(text.substr(text.find("voxels of about ") + 16));
    EXPECT_LE(plan_distance_grid(tool.mesh, fitting).working_bytes, 1e6) << text;
  }
}

TEST(ClippedTool, HasAGridOnlyWhereTeethTurn) {
  Diagnostics report;
  Tool toothed = tool_of(gear_mesh(6, 4, 6, 5));
  prepare_clipping(toothed, {}, 0.5, 1e9, report);
  EXPECT_FALSE(toothed.teeth) << "using its envelope";
  prepare_clipping(toothed, resolved(), 0.5, 1e9, report);
  ASSERT_TRUE(toothed.teeth);
  EXPECT_EQ(toothed.clip_slack_mm(), toothed.teeth->slack_mm);
  EXPECT_EQ(report.notes.size(), 1U) << "what the grid's volume is";
  Tool round = tool_of(sphere_mesh({0, 0, 5}, 5, 4), true);
  prepare_clipping(round, resolved(), 0.5, 1e9, report);
  EXPECT_FALSE(round.teeth);
  EXPECT_TRUE(report.warnings.empty()) << report.warnings[0];
}

TEST(ClippedTool, WarnsOfACoarseGrid) {
  Tool tool = tool_of(gear_mesh(6, 4, 6, 5));
  Diagnostics report;
  prepare_clipping(tool, resolved(), 1.0, 1e9, report);
  ASSERT_EQ(report.warnings.size(), 1U);
  EXPECT_NE(report.warnings[0].find("the difference exceeds 0.5 %"), std::string::npos) << report.warnings[0];
}

TEST(ThinWalls, OfAMesh) {
  // A bar across the axis, 0.6 mm thin.
  const TriangleMesh bar = box_mesh({-6, -0.3, 0}, {6, 0.3, 5});
  const auto wall = thinnest_wall(bar, 1.0);
  ASSERT_TRUE(wall);
  EXPECT_NEAR(wall->thickness_mm, 0.6, 1e-6);
  EXPECT_NEAR(std::abs(wall->at_mm.y()), 0.3, 1e-9);
  EXPECT_FALSE(thinnest_wall(bar, 0.5));
  // Teeth end in right angles, which are edges and no walls.
  EXPECT_FALSE(thinnest_wall(gear_mesh(6, 4, 6, 5), 1.0));
  EXPECT_NEAR(thinnest_wall(gear_mesh(24, 4, 6, 5), 1.0)->thickness_mm, 4 * M_PI / 24, 0.05) << "a narrow tooth's root";
}

TEST(ThinWalls, OfAProfile) {
  // A cup with a wall of 0.4 mm, listed with the inside on the left.
  Profile cup;
  cup.points = {{0, 0}, {5, 0}, {5, 6}, {4.6, 6}, {4.6, 2}, {0, 2}};
  ASSERT_GT(cup.volume_mm3(), 0);
  const auto wall = thinnest_wall(cup, 1.0);
  ASSERT_TRUE(wall);
  EXPECT_NEAR(wall->thickness_mm, 0.4, 1e-6);
  EXPECT_GT(wall->at_mm.z(), 1.9);
  EXPECT_FALSE(thinnest_wall(cup, 0.35));
  // A pin is as thin as its diameter.
  Profile pin;
  pin.points = {{0, 0}, {0.3, 0}, {0.3, 5}, {0, 5}};
  EXPECT_NEAR(thinnest_wall(pin, 1.0)->thickness_mm, 0.6, 1e-6);
}

TEST(ClippedTool, WarnsOfAThinWallWithItsSize) {
  Diagnostics report;
  Tool bar = tool_of(box_mesh({-6, -0.3, 0}, {6, 0.3, 5}));
  prepare_clipping(bar, {}, 0.5, 1e9, report);
  EXPECT_TRUE(report.warnings.empty()) << "what it sweeps is a cylinder: " << report.warnings[0];
  prepare_clipping(bar, resolved(), 0.5, 1e9, report);
  ASSERT_FALSE(report.warnings.empty());
  EXPECT_NE(report.warnings[0].find("0.6 mm thick at"), std::string::npos) << report.warnings[0];
  EXPECT_NE(report.warnings[0].find("use voxels of 0.3 mm or less"), std::string::npos) << report.warnings[0];
}

}  // namespace
}  // namespace reamsim::test
