// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/substep.h"

#include <gtest/gtest.h>

#include "sim/tool/point_shell.h"
#include "tests/engine/scene_fixture.h"

namespace reamsim::test::substep_tests {
namespace {

TEST(Substep, NoPointMovesFurtherThanTheStep) {
  const Tool tool = make_tool(cap_profile(29, 30, 8, 1.25), 32);
  ToolPose a, b;
  b.position_mm = {0.3, -0.4, 1.2};
  b.orientation = Quat(Eigen::AngleAxisd(0.05, Vec3::UnitX()));
  b.spin_angle_rad = 0.2;
  for (const bool resolved : {false, true}) {
    const double step = 0.125;
    const int n = count_substeps(a, b, tool, resolved, step);
    double longest = 0;
    for (int i = 0; i < n; ++i) {
      const Rigid begin = bone_from_shell(interpolate(a, b, double(i) / n), resolved);
      const Rigid end = bone_from_shell(interpolate(a, b, double(i + 1) / n), resolved);
      for (const Vec3& v : tool.mesh.vertices) longest = std::max(longest, (end * v - begin * v).norm());
    }
    EXPECT_LE(longest, step * (1 + 1e-6)) << "resolved " << resolved;
    EXPECT_GT(longest, step * 0.5) << "resolved " << resolved << ": more substeps than needed";
  }
}

TEST(Substep, StandingStillIsOneSubstep) {
  const Tool tool = make_tool(cap_profile(29, 30, 8, 1.25), 16);
  EXPECT_EQ(count_substeps({}, {}, tool, true, 0.1), 1);
}

TEST(Substep, VelocitiesGiveTheEndPose) {
  ToolPose a, b;
  a.position_mm = {1, 2, 3};
  b.position_mm = {1.5, 2, 2};
  b.orientation = Quat(Eigen::AngleAxisd(0.3, Vec3::UnitY()));
  b.spin_angle_rad = 0.1;
  const Substep s = make_substep(a, b, 0, 1, 0.5, 1);
  EXPECT_NEAR((s.origin_velocity_mm_s - Vec3(1, 0, -2)).norm(), 0, 1e-12);
  const Vec3 spin = -0.2 * (b.orientation * Vec3::UnitZ());
  EXPECT_NEAR((s.angular_velocity - spin - Vec3(0, 0.6, 0)).norm(), 0, 1e-12);
}

TEST(Substep, FixedPointPositionsFollowTheTransform) {
  const Tool tool = make_tool(cap_profile(29, 30, 8, 1.25), 200);
  ToolPose pose;
  pose.position_mm = {3.3, -2.2, 1.1};
  pose.orientation = Quat(0.9, 0.1, -0.3, 0.2).normalized();
  const VoxelGrid grid{{300, 300, 300}, 0.25, {-37, -36, -35}};
  Substep substep;
  substep.pose = pose;
  substep.duration_s = 1e-3;
  const SubstepArgs args = make_args(substep, tool.bounds, tool.shell, grid, {}, false);
  int differ = 0, total = 0;
  for (const std::uint64_t code : tool.shell.codes) {
    const Vec3i cell = morton_decode(code);
    const int x = cell.x(), y = cell.y(), z = cell.z();
    EXPECT_TRUE(rs_in_voi(&args, x, y, z));
    const Vec3 p =
        pose.bone_from_tool() * (tool.shell.origin_mm + tool.shell.cell_mm * Vec3(x + 0.5, y + 0.5, z + 0.5));
    const Vec3i exact = grid.voxel_of(p);
    const Vec3i fixed(rs_voxel_coordinate(&args, 0, x, y, z), rs_voxel_coordinate(&args, 1, x, y, z),
                      rs_voxel_coordinate(&args, 2, x, y, z));
    EXPECT_LE((exact - fixed).cwiseAbs().maxCoeff(), 1);
    differ += exact != fixed;
    ++total;
  }
  // Fixed point and double part only for points within 2^-15 voxel of a face.
  EXPECT_LT(differ, 2 + total / 5000);
}

}  // namespace
}  // namespace reamsim::test::substep_tests
