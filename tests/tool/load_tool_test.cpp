// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// load_tool: what it builds from a scenario, and what it says about tools that cannot be right.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/tool/point_shell.h"
#include "sim/tool/profile.h"
#include "sim/tool/tool.h"
#include "tests/support/temp_dir.h"
#include "tests/tool/reamer_files.h"

namespace reamsim::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

ToolSettings shipped(const std::string& name, int resolution = 0) {
  ToolSettings settings;
  settings.mesh = reamer_path(name);
  settings.shell_resolution = resolution;
  return settings;
}

class LoadTool : public testing::Test {
 protected:
  /// Writes a mesh and returns settings that name it.
  ToolSettings saved(const TriangleMesh& mesh) {
    ToolSettings settings;
    settings.mesh = dir_.path() + "/tool.stl";
    write_stl(settings.mesh, mesh);
    return settings;
  }

  std::string error_of(const ToolSettings& settings, double voxel_mm = 0.5) {
    try {
      load_tool(settings, voxel_mm, ShellUse::touches_voxels, report_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  TempDir dir_;
  Diagnostics report_;
};

TEST_F(LoadTool, ChoosesAResolutionWithoutALeak) {
  const Tool tool = load_tool(shipped("convex"), 0.25, ShellUse::touches_voxels, report_);
  EXPECT_EQ(tool.shell.resolution, 256) << "30 mm over 255 steps of 0.1176 mm: 0.47 of a voxel";
  EXPECT_LT(tool.shell.cell_mm, 0.125);
  EXPECT_NEAR(tool.shell.cell_mm, 30.0 / 255, 1e-6);
  EXPECT_THAT(report_.warnings, IsEmpty());
  EXPECT_NEAR(tool.bounds.max.x(), 15, 1e-5);
  EXPECT_NEAR(tool.bounds.min.y(), -15, 1e-5);
  EXPECT_NEAR(tool.bounds.max.z(), 30, 1e-5);
  EXPECT_NEAR(tool.reach_mm, std::hypot(3.5, 30), 0.125);
}

TEST_F(LoadTool, EnvelopeFillsTheChipSlotsAndResolvedKeepsThem) {
  ToolSettings settings = shipped("convex_edges", 128);
  const Tool envelope = load_tool(settings, 0.5, ShellUse::touches_voxels, report_);
  settings.spin = ToolSpin::resolved;
  const Tool resolved = load_tool(settings, 0.5, ShellUse::touches_voxels, report_);
  const Tool convex = load_tool(shipped("convex", 128), 0.5, ShellUse::touches_voxels, report_);
  EXPECT_NEAR(static_cast<double>(envelope.shell.codes.size()) / static_cast<double>(convex.shell.codes.size()), 1,
              0.02);
  // Shell points within the slots' radii just above the face: everywhere in the envelope, on the cutting edges
  // otherwise.
  const auto near_face = [](const Tool& tool) {
    int count = 0;
    for (const std::uint64_t code : tool.shell.codes) {
      const Vec3 p =
          tool.shell.origin_mm + tool.shell.cell_mm * (morton_decode(code).cast<double>().array() + 0.5).matrix();
      const double from_sphere = std::abs((p - Vec3(0, 0, 29)).norm() - 29);
      if (radius_of(p) > 8 && radius_of(p) < 12 && p.z() < 4 && from_sphere < 0.2) ++count;
    }
    return count;
  };
  EXPECT_LT(near_face(resolved), 0.5 * near_face(envelope));
  EXPECT_GT(near_face(resolved), 0.05 * near_face(envelope));
}

TEST_F(LoadTool, WarnsOfALeakWithItsSize) {
  load_tool(shipped("convex", 121), 0.25, ShellUse::touches_voxels, report_);
  ASSERT_EQ(report_.warnings.size(), 1u);
  EXPECT_THAT(report_.warnings[0],
              AllOf(HasSubstr("tool.shell_resolution"), HasSubstr("1 voxels"), HasSubstr("about 4.2 %")));
}

TEST_F(LoadTool, SaysWhetherALeakIsABoundOrAFigure) {
  load_tool(shipped("convex", 201), 0.25, ShellUse::touches_voxels, report_);
  load_tool(shipped("convex", 31), 0.25, ShellUse::touches_voxels, report_);
  EXPECT_THAT(report_.warnings, testing::ElementsAre(AllOf(HasSubstr("0.6 voxels"), HasSubstr("less than 0.0001 %")),
                                                     AllOf(HasSubstr("4 voxels"), HasSubstr("more than 86.6 %"))));
}

TEST_F(LoadTool, AShellThatTouchesNoVoxelsLeavesNoneBehind) {
  const Tool tool = load_tool(shipped("convex", 31), 0.25, ShellUse::none, report_);
  EXPECT_EQ(tool.shell.resolution, 31);
  EXPECT_TRUE(tool.shell.codes.empty());
  EXPECT_THAT(report_.warnings, IsEmpty());
}

TEST_F(LoadTool, AShellThatTouchesNoVoxelsMayBeCoarserThanTheyAre) {
  // Cells of half a voxel would be 6001 an axis, more than are possible.
  const Tool tool = load_tool(shipped("convex"), 0.01, ShellUse::none, report_);
  EXPECT_EQ(tool.shell.resolution, 1024);
  EXPECT_NEAR(tool.reach_mm, std::hypot(3.5, 30), tool.shell.cell_mm);
  EXPECT_THAT(report_.warnings, IsEmpty());
}

TEST_F(LoadTool, SaysWhatWouldDoWhenTheShellIsTooFine) {
  EXPECT_THAT(error_of(shipped("convex"), 0.01),
              AllOf(HasSubstr("tool.shell_resolution"), HasSubstr("takes 6001 cells per axis and 4096 are possible"),
                    HasSubstr("bone.voxel_mm of 0.0147"), HasSubstr("tool.shell_resolution: 4096 with a leak")));
}

TEST_F(LoadTool, GoesBeyond1024CellsWhereTheVoxelsAskForIt) {
  const Tool tool = load_tool(shipped("convex"), 0.05, ShellUse::touches_voxels, report_);
  EXPECT_EQ(tool.shell.resolution, 1272) << "30 mm over 1271 steps of 0.0236 mm: 0.47 of a voxel";
  EXPECT_GT(tool.shell.codes.back(), UINT32_MAX);
  EXPECT_THAT(report_.warnings, IsEmpty());
}

TEST_F(LoadTool, DiagnosesAnOpenMesh) {
  TriangleMesh open = reamer("flat");
  open.triangles.pop_back();
  EXPECT_THAT(error_of(saved(open)), AllOf(HasSubstr("tool.mesh"), HasSubstr("tool.stl"), HasSubstr("3 boundary edges"),
                                           HasSubstr("closed two-manifold")));
}

TEST_F(LoadTool, RefusesAToolBesideTheAxis) {
  TriangleMesh beside = reamer("flat");
  for (Vec3& p : beside.vertices) p.x() += 5;
  EXPECT_THAT(error_of(saved(beside)), AllOf(HasSubstr("5 mm off the z axis"), HasSubstr("place the spin axis on z")));
}

TEST_F(LoadTool, WarnsOfAToolSlightlyOffTheAxis) {
  TriangleMesh off = reamer("flat");
  for (Vec3& p : off.vertices) p.x() += 0.4;
  const Tool tool = load_tool(saved(off), 0.5, ShellUse::touches_voxels, report_);
  EXPECT_THAT(report_.warnings, testing::ElementsAre(HasSubstr("0.4 mm off the z axis")));
  EXPECT_NEAR(tool.profile.max_radius_mm(), 13.9, 0.02) << "the envelope of what it sweeps";
}

TEST_F(LoadTool, TurnsAnInsideOutMeshRound) {
  TriangleMesh inverted = reamer("flat");
  for (auto& t : inverted.triangles) std::swap(t[1], t[2]);
  const Tool tool = load_tool(saved(inverted), 0.5, ShellUse::touches_voxels, report_);
  EXPECT_GT(tool.mesh.volume_mm3(), 0);
  EXPECT_NEAR(tool.profile.volume_mm3(), 3380.2, 1);
  EXPECT_THAT(report_.warnings, testing::ElementsAre(HasSubstr("inwards")));
}

TEST_F(LoadTool, WarnsWhenTheOriginIsNotAtTheCuttingEnd) {
  TriangleMesh high = reamer("flat");
  for (Vec3& p : high.vertices) p.z() += 20;
  load_tool(saved(high), 0.5, ShellUse::touches_voxels, report_);
  EXPECT_THAT(report_.warnings, testing::ElementsAre(HasSubstr("lowest point is at z = 20 mm")));
}

TEST_F(LoadTool, WarnsOfAnyApexBelowTheOrigin) {
  TriangleMesh low = reamer("hemispherical");
  const double lowest = low.bounds().min.z();
  for (Vec3& p : low.vertices) p.z() -= lowest + 0.1;
  load_tool(saved(low), 0.5, ShellUse::touches_voxels, report_);
  EXPECT_THAT(report_.warnings, testing::ElementsAre(HasSubstr("lowest point is at z = -0.1 mm")));
}

TEST_F(LoadTool, ScaleMakesMillimetres) {
  ToolSettings settings = shipped("flat");
  settings.scale = 2;
  EXPECT_NEAR(load_tool(settings, 0.5, ShellUse::touches_voxels, report_).profile.max_radius_mm(), 27, 1e-5);
  settings.scale = 0.001;
  EXPECT_THAT(error_of(settings), AllOf(HasSubstr("0.027 × 0.027 × 0.027 mm"), HasSubstr("tool.scale")));
  settings.scale = 1000;
  EXPECT_THAT(error_of(settings), AllOf(HasSubstr("2.7e+04 mm"), HasSubstr("less than 1 m")));
}

TEST_F(LoadTool, NamesAFileThatIsNotThere) {
  ToolSettings settings;
  settings.mesh = dir_.path() + "/absent.stl";
  EXPECT_THAT(error_of(settings), HasSubstr("absent.stl"));
}

TEST(Leak, FollowsTheMeasuredTable) {
  EXPECT_EQ(expected_leak(0.5), 0);
  EXPECT_DOUBLE_EQ(expected_leak(0.6), 1e-6);
  EXPECT_DOUBLE_EQ(expected_leak(0.8), 8e-4);
  EXPECT_DOUBLE_EQ(expected_leak(1.0), 4.2e-2);
  EXPECT_DOUBLE_EQ(expected_leak(9), expected_leak(3));
  for (double s = 0.7; s < 2.9; s += 0.01) EXPECT_GT(expected_leak(s + 0.01), expected_leak(s)) << s;
}

}  // namespace
}  // namespace reamsim::test
