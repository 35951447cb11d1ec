// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The geometry of `implicit`: which voxels the solid of revolution holds, where it looks for them, and how far its
// result may be from that of the shell.
#include <gtest/gtest.h>

#include <iostream>

#include "kernels/cut_law.h"
#include "sim/engine/common/substep.h"
#include "sim/engine/dense/dense_state.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::implicit_tests {
namespace {

constexpr unsigned kSeed = 20200416;

/// A hemisphere of radius 4 mm, closed on the axis; a bored cap; a flat disc with a neck, concave in (r, z).
std::vector<Profile> profiles() {
  Profile hemisphere, flat;
  for (int i = 0; i <= 64; ++i) {
    const double angle = M_PI / 2 * i / 64;
    hemisphere.points.emplace_back(i == 0 ? 0 : 4 * std::sin(angle), 4 - 4 * std::cos(angle));
  }
  hemisphere.points.emplace_back(0, 4);
  flat.points = {{0, 0}, {3, 0}, {3, 1}, {0.8, 1.2}, {0.8, 4}, {0, 4}};
  return {hemisphere, cap_profile(5, 6, 2.5, 0.6), flat};
}

bool inside(const Profile& profile, double r, double z) {
  const OutlineTable table = full_outline_table(profile, 1);
  const OutlineView view = view_of(table);
  return rs_inside_outline(&view, static_cast<float>(r), static_cast<float>(z)) != 0;
}

TEST(Implicit, InsideWhereTheSignedDistanceIsNotPositive) {
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(0, 6);
  for (const Profile& profile : profiles()) {
    int in = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec2 p(i % 50 == 0 ? 0 : u(random), u(random) - 1);
      const double distance = profile.nearest(p).distance_mm;
      // The kernels' profile is in single precision. On the axis itself there is no surface.
      if (std::abs(distance) < 1e-5) continue;
      EXPECT_EQ(inside(profile, p.x(), p.y()), distance < 0) << p.transpose() << " distance " << distance;
      in += distance < 0;
    }
    EXPECT_GT(in, 1000);
  }
}

TEST(Implicit, TheSolidIsClosed) {
  for (const Profile& profile : profiles()) {
    for (const Vec2& vertex : profile.points) EXPECT_TRUE(inside(profile, vertex.x(), vertex.y())) << vertex;
  }
  const Profile flat = profiles().back();
  EXPECT_TRUE(inside(flat, 1.5, 0));  // on the cutting face
  EXPECT_FALSE(inside(flat, 1.5, -2e-6));
  EXPECT_TRUE(inside(flat, 3, 0.5));  // on the rim
  EXPECT_FALSE(inside(flat, 3 + 2e-6, 0.5));
  EXPECT_TRUE(inside(flat, 0, 2));  // on the axis
}

TEST(Implicit, HemisphereIsASphereBelowItsEquator) {
  // Against the analytic surface; the polygon's chords leave at most their sagitta.
  const Profile hemisphere = profiles().front();
  const double sagitta = 4 * (1 - std::cos(M_PI / 4 / 64));
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(0, 5);
  for (int i = 0; i < 20000; ++i) {
    const double r = u(random), z = u(random) * 0.79;
    const double from_center = std::hypot(r, z - 4);
    if (from_center > 4 - sagitta && from_center < 4) continue;
    EXPECT_EQ(inside(hemisphere, r, z), from_center < 4) << r << ' ' << z;
  }
}

TEST(Implicit, TheVoiHoldsEveryVoxelThatTheToolHolds) {
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  const SimulationInput scene = oblique_scene("serial", "implicit");
  const VoxelGrid& grid = scene.bone.voxmap->grid;
  const VoxelBox bone = bone_extent(*scene.bone.voxmap);
  const OutlineTable table = full_outline_table(scene.tool.profile, 1);
  const OutlineView outline = view_of(table);
  std::int64_t held = 0, looked_at = 0;
  for (int trial = 0; trial < 40; ++trial) {
    Substep substep;
    substep.duration_s = 1e-3;
    substep.pose.position_mm = 4 * Vec3(u(random), u(random), u(random));
    substep.pose.orientation = Quat(u(random), u(random), u(random), u(random)).normalized();
    const SubstepArgs args = make_args(substep, scene.tool.bounds, scene.tool.shell, grid, {}, false);
    const VoxelBox voi = voxel_voi(args, scene.tool.profile.bounds(), bone);
    looked_at += voi.size().cast<std::int64_t>().prod();
    for (std::int64_t e = 0; e < grid.size(); ++e) {
      const Vec3i c = grid.coord(e);
      if (!rs_contains_voxel(&args, &outline, c.x(), c.y(), c.z())) continue;
      ++held;
      EXPECT_TRUE((c.array() >= voi.first.array()).all() && (c.array() <= voi.last.array()).all()) << c.transpose();
    }
  }
  EXPECT_GT(held, 10000);
  EXPECT_LT(looked_at, 40 * grid.size() * 3 / 4) << "it culls";
}

/// The signed distance (mm) of a point of B to the solid that the tool sweeps along the motion, sampled finely.
double swept_distance(const SimulationInput& scene, const Vec3& point) {
  double least = 1e9;
  for (std::size_t k = 1; k < scene.motion.poses.size(); ++k) {
    for (int i = 0; i < 4; ++i) {
      const ToolPose pose = interpolate(scene.motion.poses[k - 1], scene.motion.poses[k], (i + 1) / 4.0);
      const Vec3 t = pose.bone_from_tool().inverse() * point;
      least = std::min(least, scene.tool.profile.nearest({std::hypot(t.x(), t.y()), t.z()}).distance_mm);
    }
  }
  return least;
}

/// What `direct` and `implicit` leave differently lies by the surface that the tool swept.
void expect_close(SimulationInput scene) {
  const double voxel = scene.bone.voxmap->grid.voxel_mm;
  scene.tool = make_tool(scene.tool.profile, static_cast<int>(6 / (0.47 * voxel)) + 2);
  ASSERT_LE(scene.tool.shell.cell_mm, 0.5 * voxel);
  scene.scenario.engine.type = EngineKind::direct;
  const Outcome direct = run(scene);
  scene.scenario.engine.type = EngineKind::implicit;
  const Outcome implicit = run(scene);
  EXPECT_GT(implicit.removed.size(), 500U);
  int more = 0;
  double farthest_out = 0, farthest_in = 0;
  for (std::int64_t e = 0; e < scene.bone.voxmap->grid.size(); ++e) {
    const auto i = static_cast<std::size_t>(e);
    if (direct.fill[i] == implicit.fill[i]) continue;
    const Vec3i c = scene.bone.voxmap->grid.coord(e);
    const double distance = swept_distance(scene, scene.bone.voxmap->grid.center_mm(c)) / voxel;
    farthest_out = std::max(farthest_out, distance);
    farthest_in = std::max(farthest_in, -distance);
    more += direct.fill[i] == 0;
  }
  std::cout << "direct takes " << direct.removed.size() << " voxels, implicit " << implicit.removed.size() << ", "
            << more << " only direct; centres at most " << farthest_out << " voxels outside the swept surface, "
            << farthest_in << " inside\n";
  EXPECT_GT(more, 0);
  // A shell point lies within half a cell's diagonal of the surface, and its voxel's centre within half a voxel's
  // diagonal of it: so some part of the voxel is always within one voxel of the surface.
  EXPECT_LT(farthest_out, std::sqrt(3.0) / 2 * 1.5);
  EXPECT_LT(farthest_in, 1);
}

TEST(Implicit, PlungeDiffersFromDirectOnlyByTheSweptSurface) {
  SimulationInput scene = oblique_scene("auto");
  scene.bone.set_voxels(block({8, 8, 4}, 0.2, 1.2));
  scene.motion = straight({0.03, 0.05, 0.4}, {0.03, 0.05, -1.7}, 60, 100, 250);
  expect_close(scene);
}

TEST(Implicit, SidewaysMoveDiffersFromDirectOnlyByTheSweptSurface) {
  SimulationInput scene = oblique_scene("auto");
  scene.bone.set_voxels(block({12, 8, 4}, 0.2, 1.2));
  scene.motion = straight({-10, 0.05, -1.03}, {2, 0.4, -1.03}, 120, 100, 250);
  expect_close(scene);
}

}  // namespace
}  // namespace reamsim::test::implicit_tests
