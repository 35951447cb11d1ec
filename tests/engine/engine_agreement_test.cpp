// The OpenCL engine against the serial reference: same voxels, same forces, same bytes.
#include <gtest/gtest.h>

#include <iostream>

#include "tests/engine/outcome.h"

namespace reamsim::test {
namespace {

TEST(EngineAgreement, RemoveEqualsTheSerialReference) {
  const Outcome serial = run(oblique_scene("serial"));
  EXPECT_GT(serial.totals.removed_mm3, 5);
  expect_same(run(oblique_scene("auto")), serial);
}

TEST(EngineAgreement, WearEqualsTheSerialReference) {
  const auto scene = [](const std::string& device) {
    ReamingScene s = oblique_scene(device);
    s.scenario.cutting.erosion = "wear";
    s.scenario.cutting.wear_g_cm3_per_s = 30;
    return s;
  };
  const Outcome serial = run(scene("serial"));
  EXPECT_GT(serial.totals.removed_mm3, 1);
  const auto partial = std::count_if(serial.fill.begin(), serial.fill.end(), [](auto f) { return f > 0 && f < 65535; });
  EXPECT_GT(partial, 100);
  expect_same(run(scene("auto")), serial);
}

TEST(EngineAgreement, PerPointLawEqualsTheSerialReference) {
  const auto scene = [](const std::string& device) {
    ReamingScene s = oblique_scene(device);
    s.scenario.cutting.law = "per_point";
    return s;
  };
  const Outcome serial = run(scene("serial"));
  EXPECT_GT(serial.totals.peak_force_n, 0);
  expect_same(run(scene("auto")), serial);
}

TEST(EngineAgreement, ResolvedSpinEqualsTheSerialReference) {
  const auto scene = [](const std::string& device) {
    ReamingScene s = oblique_scene(device);
    s.scenario.tool.spin = "resolved";
    return s;
  };
  const Outcome serial = run(scene("serial"));
  EXPECT_GT(serial.totals.removed_mm3, 5);
  expect_same(run(scene("auto")), serial);
}

TEST(EngineAgreement, PartlyReamedBoneEqualsTheSerialReference) {
  const auto scene = [](const std::string& device) {
    ReamingScene s = oblique_scene(device);
    std::mt19937 random(11);
    for (std::int64_t e = 0; e < s.bone.voxmap.grid.size(); e += 3) {
      s.bone.voxmap.fill.set(s.bone.voxmap.grid.coord(e), static_cast<std::uint16_t>(random() % 65536));
    }
    return s;
  };
  expect_same(run(scene("auto")), run(scene("serial")));
}

TEST(EngineAgreement, WorkGroupAndBatchDoNotMatter) {
  const Outcome reference = run(oblique_scene("auto"));
  for (const int group : {1, 7, 64, 200}) {
    for (const int batch : {1, 10, 1000}) {
      ReamingScene scene = oblique_scene("auto");
      scene.scenario.engine.work_group_size = group;
      scene.scenario.engine.batch_frames = batch;
      SCOPED_TRACE("work group " + std::to_string(group) + ", batch " + std::to_string(batch));
      expect_same(run(scene), reference);
    }
  }
}

TEST(EngineAgreement, RandomScenes) {
  constexpr unsigned kSeed = 4711;
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int trial = 0; trial < 12; ++trial) {
    const Vec3i dims(1 + static_cast<int>(random() % 40), 1 + static_cast<int>(random() % 40),
                     1 + static_cast<int>(random() % 40));
    const auto bone_seed = static_cast<unsigned>(random());
    const int resolution = 1 + static_cast<int>(random() % 50);
    const Quat tilt = Quat(u(random), u(random), u(random), u(random)).normalized();
    const Vec3 from(6 * u(random), 6 * u(random), 6 * u(random)), to(2 * u(random), 2 * u(random), 2 * u(random));
    const auto scene = [&](const std::string& device) {
      ReamingScene s;
      s.scenario = quiet_scenario(device);
      s.bone.voxmap = random_bone(dims, 0.25, bone_seed);
      s.bone.voxmap.grade[0] = 100;  // never without bone
      s.tool = make_tool(cap_profile(5, 6, 2.5, 0.6), resolution);
      s.motion = straight(from, to, 20, 50, 100, tilt);
      return s;
    };
    SCOPED_TRACE("trial " + std::to_string(trial));
    expect_same(run(scene("auto")), run(scene("serial")));
  }
}

TEST(EngineAgreement, OneVoxelOnePoint) {
  const auto scene = [](const std::string& device) {
    ReamingScene s;
    s.scenario = quiet_scenario(device);
    VoxelGrid grid{{1, 1, 1}, 1.0, {-0.5, -0.5, -0.5}};
    s.bone.voxmap = Voxmap(grid);
    s.bone.voxmap.grade[0] = 225;
    s.tool = make_tool(cap_profile(5, 6, 2.5, 0.6), 8);
    s.tool.shell.codes = {s.tool.shell.codes.front()};
    const PointShell& shell = s.tool.shell;
    const Vec3 point =
        shell.origin_mm + shell.cell_mm * (Vec3(rs_compact_bits(shell.codes[0]), rs_compact_bits(shell.codes[0] >> 1),
                                                rs_compact_bits(shell.codes[0] >> 2)) +
                                           Vec3::Constant(0.5));
    s.motion = straight(-point + Vec3(0, 0, 2), -point, 10, 100, 60);
    return s;
  };
  const Outcome device = run(scene("auto"));
  EXPECT_EQ(device.removed.size(), 1U);
  EXPECT_DOUBLE_EQ(device.totals.removed_mm3, 1.0);
  expect_same(device, run(scene("serial")));
}

TEST(EngineAgreement, ToolFullyInsideTouchesOnlyItsSurface) {
  ReamingScene scene;
  scene.scenario = quiet_scenario("auto");
  scene.bone.voxmap = block({12, 12, 12}, 0.25, 1.0);
  scene.tool = make_tool(cap_profile(5, 6, 2.5, 0.6), 48);
  scene.motion = straight({0, 0, -6}, {0, 0, -6.1}, 1, 1000, 250);
  const Outcome outcome = run(scene);
  EXPECT_GT(outcome.removed.size(), 100U);
  for (const auto& [voxel, frame] : outcome.removed) {
    const Vec3i c = scene.bone.voxmap.grid.coord(voxel);
    const Vec3 p = scene.bone.voxmap.grid.center_mm(c.x(), c.y(), c.z()) - Vec3(0, 0, -6.1);
    const double distance = scene.tool.profile.nearest({std::hypot(p.x(), p.y()), p.z()}).distance_mm;
    // A touched voxel holds a point, which lies within half a cell's diagonal of the surface.
    EXPECT_LT(std::abs(distance), std::sqrt(3.0) * (0.25 + scene.tool.shell.cell_mm) / 2 + 0.02);
  }
  EXPECT_EQ(outcome.report.warnings.size(), 1U);  // it starts in contact
}

TEST(EngineAgreement, NoContactNoForce) {
  ReamingScene scene = oblique_scene("auto");
  scene.motion = straight({0, 0, 60}, {0, 0, 50}, 20, 1000, 250);
  const Outcome outcome = run(scene);
  EXPECT_EQ(outcome.totals.contact_frames, 0);
  EXPECT_EQ(outcome.totals.removed_mm3, 0);
  ASSERT_EQ(outcome.report.warnings.size(), 1U);
  EXPECT_NE(outcome.report.warnings[0].find("never touches"), std::string::npos);
}

}  // namespace
}  // namespace reamsim::test
