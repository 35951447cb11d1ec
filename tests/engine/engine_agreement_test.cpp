// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Each OpenCL engine against its serial reference: same voxels, same forces, same bytes.
#include <gtest/gtest.h>

#include <iostream>

#include "sim/tool/point_shell.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::engine_agreement_tests {
namespace {

/// Runs a scene on the serial reference and on the device, with the engine under test.
class Agreement : public testing::TestWithParam<std::string> {
 protected:
  template <class Change>
  static SimulationInput changed(const std::string& device, const Change& change) {
    SimulationInput scene = oblique_scene(device, GetParam());
    change(scene);
    return scene;
  }

  /// The device's outcome on the oblique scene, after `change` and after checking that it is the reference's.
  template <class Change>
  static Outcome agreed(const Change& change) {
    const Outcome device = run(changed("auto", change));
    expect_same(device, run(changed("serial", change)));
    return device;
  }
};

/// All engines.
using EngineAgreement = Agreement;
/// Those that have a shell: they share one serial reference, so what holds for one of them holds between them.
class ShellAgreement : public Agreement {};

std::string name_of(const testing::TestParamInfo<std::string>& tested) {
  return tested.param;
}

INSTANTIATE_TEST_SUITE_P(Engines, EngineAgreement, testing::ValuesIn(kEngines), name_of);
INSTANTIATE_TEST_SUITE_P(Engines, ShellAgreement, testing::ValuesIn(kShellEngines), name_of);

TEST_P(EngineAgreement, Remove) {
  EXPECT_GT(agreed([](SimulationInput&) {}).totals.removed_mm3, 5);
}

TEST_P(EngineAgreement, Wear) {
  const Outcome outcome = agreed([](SimulationInput& s) {
    s.scenario.cutting.erosion = ErosionMode::wear;
    s.scenario.cutting.wear_g_cm3_per_s = 30;
  });
  EXPECT_GT(outcome.totals.removed_mm3, 1);
  const auto partial =
      std::count_if(outcome.fill.begin(), outcome.fill.end(), [](auto f) { return f > 0 && f < 65535; });
  EXPECT_GT(partial, 100);
}

TEST_P(ShellAgreement, PerPointLaw) {
  for (const int group : {0, 1, 7, 200, 256}) {
    SCOPED_TRACE("work group " + std::to_string(group));
    const Outcome outcome = agreed([&](SimulationInput& s) {
      s.scenario.cutting.law = CuttingLaw::per_point;
      s.scenario.engine.tuning.work_group_size = group;
    });
    EXPECT_GT(outcome.totals.peak_force_n, 0);
  }
}

TEST_P(ShellAgreement, ResolvedSpin) {
  EXPECT_GT(agreed([](SimulationInput& s) { s.tool.spin = ToolSpin::resolved; }).totals.removed_mm3, 5);
}

TEST_P(EngineAgreement, PartlyReamedBone) {
  const Outcome outcome = agreed([](SimulationInput& s) {
    std::mt19937 random(11);
    for (std::int64_t e = 0; e < s.bone.voxmap->grid.size(); e += 3) {
      s.bone.fill.set(s.bone.voxmap->grid.coord(e), static_cast<std::uint16_t>(random() % 65536));
    }
  });
  EXPECT_GT(outcome.totals.removed_mm3, 1);
}

TEST_P(EngineAgreement, WorkGroupAndBatchDoNotMatter) {
  const Outcome reference = run(oblique_scene("auto", GetParam()));
  for (const int group : {1, 7, 64, 200}) {
    for (const int batch : {1, 10, 1000}) {
      SimulationInput scene = oblique_scene("auto", GetParam());
      scene.scenario.engine.tuning.work_group_size = group;
      scene.scenario.engine.batch_frames = batch;
      SCOPED_TRACE("work group " + std::to_string(group) + ", batch " + std::to_string(batch));
      expect_same(run(scene), reference);
    }
  }
}

TEST_P(EngineAgreement, RandomScenes) {
  constexpr unsigned kSeed = 4711;
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  int removing = 0;
  for (int trial = 0; trial < 12; ++trial) {
    const Vec3i dims(1 + static_cast<int>(random() % 40), 1 + static_cast<int>(random() % 40),
                     1 + static_cast<int>(random() % 40));
    const auto bone_seed = static_cast<unsigned>(random());
    const int resolution = 1 + static_cast<int>(random() % 50);
    const Quat tilt = Quat(u(random), u(random), u(random), u(random)).normalized();
    const Vec3 from(6 * u(random), 6 * u(random), 6 * u(random)), to(2 * u(random), 2 * u(random), 2 * u(random));
    SCOPED_TRACE("trial " + std::to_string(trial));
    const Outcome outcome = agreed([&](SimulationInput& s) {
      FilledVoxmap bone = random_bone(dims, 0.25, bone_seed);
      bone.grade.set({0, 0, 0}, 100);  // never without bone
      s.bone.set_voxels(std::move(bone));
      s.tool = make_tool(cap_profile(5, 6, 2.5, 0.6), resolution);
      s.motion = straight(from, to, 20, 50, 100, tilt);
    });
    removing += outcome.removed.empty() ? 0 : 1;
  }
  EXPECT_GE(removing, 6);
}

TEST_P(EngineAgreement, OneVoxel) {
  const Outcome outcome = agreed([](SimulationInput& s) {
    s.bone.set_voxels(one_voxel(1.0, {1.0, -0.5, -0.5}, 225));
    s.tool = make_tool(cap_profile(5, 6, 2.5, 0.6), 30);
    s.motion = straight({0, 0, 3}, {0, 0, -1}, 40, 100, 60);
  });
  EXPECT_EQ(outcome.removed.size(), 1U);
  EXPECT_DOUBLE_EQ(outcome.totals.removed_mm3, 1.0);
}

TEST_P(ShellAgreement, OneVoxelOnePoint) {
  const Outcome outcome = agreed([](SimulationInput& s) {
    s.bone.set_voxels(one_voxel(1.0, {-0.5, -0.5, -0.5}, 225));
    s.tool = make_tool(cap_profile(5, 6, 2.5, 0.6), 8);
    s.tool.shell.codes = {s.tool.shell.codes.front()};
    const PointShell& shell = s.tool.shell;
    const Vec3 cell = morton_decode(shell.codes[0]).cast<double>();
    const Vec3 point = shell.origin_mm + shell.cell_mm * (cell + Vec3::Constant(0.5));
    s.motion = straight(-point + Vec3(0, 0, 2), -point, 10, 100, 60);
  });
  EXPECT_EQ(outcome.removed.size(), 1U);
  EXPECT_DOUBLE_EQ(outcome.totals.removed_mm3, 1.0);
}

TEST_P(ShellAgreement, AShellBeyond1024) {
  const Profile needle{{{0, 0}, {0.12, 0.1}, {0.12, 6}, {0, 6}}};
  const Tool tool = make_tool(needle, 1500);
  EXPECT_GT(tool.shell.codes.back(), UINT32_MAX) << "some codes must need more than 32 bits";
  const Outcome outcome = agreed([&](SimulationInput& s) {
    s.bone.set_voxels(random_bone({41, 37, 29}, 0.2, 23));
    s.tool = tool;
    const Quat tilt(Eigen::AngleAxisd(0.9, Vec3(1, 2, 0.5).normalized()));
    s.motion = straight({-2, 1, 3}, {-0.5, 0.3, -1}, 12, 100, 250, tilt);
  });
  EXPECT_GT(outcome.totals.removed_mm3, 0.5);
}

TEST_P(EngineAgreement, EdgeOn) {
  // The spin axis lies in the face: the cap's rim goes in first.
  const Outcome outcome = agreed([](SimulationInput& s) {
    s.bone.set_voxels(block({7, 9, 4}, 0.25, 1.1));
    s.motion = straight({0, 0, 3.2}, {0.3, -0.2, 1.9}, 20, 100, 250, Quat(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX())));
  });
  EXPECT_GT(outcome.removed.size(), 50U);
}

TEST_P(EngineAgreement, BordersOfTheVoxmap) {
  // Bone fills the lattice to every border, and the tool crosses a face, an edge and a corner of it.
  for (const Vec3& to : {Vec3(0, 0, -1), Vec3(3, 0, -1), Vec3(-3, -2.9, -1), Vec3(3, 2.9, -6)}) {
    const Outcome outcome = agreed([&](SimulationInput& s) {
      s.bone.set_voxels(block({6, 5.75, 4.25}, 0.25, 1.1));
      s.motion = straight(to + Vec3(0.1, 0, 2.2), to, 20, 100, 250);
    });
    EXPECT_GT(outcome.removed.size(), 20U) << to.transpose();
  }
}

TEST_P(EngineAgreement, ToolLargerThanTheVoxmap) {
  const Outcome outcome = agreed([](SimulationInput& s) {
    s.bone.set_voxels(block({1.5, 1, 0.75}, 0.25, 1.1));
    s.motion = straight({1.3, 0, 0.5}, {1.3, 0, -3}, 20, 100, 250);
  });
  EXPECT_EQ(outcome.removed.size(), 6U * 4 * 3);
}

TEST_P(EngineAgreement, ToolFullyInside) {
  const Outcome outcome = agreed([&](SimulationInput& s) {
    s.bone.set_voxels(block({12, 12, 12}, 0.25, 1.0));
    s.tool = make_tool(cap_profile(5, 6, 2.5, 0.6), 48);
    s.motion = straight({0, 0, -6}, {0, 0, -6.1}, 1, 1000, 250);
  });
  EXPECT_GT(outcome.removed.size(), 100U);
  EXPECT_EQ(outcome.report.warnings.size(), 1U);  // it starts in contact
}

TEST_P(ShellAgreement, ToolFullyInsideTouchesOnlyItsSurface) {
  SimulationInput scene = oblique_scene("auto", GetParam());
  scene.bone.set_voxels(block({12, 12, 12}, 0.25, 1.0));
  scene.tool = make_tool(cap_profile(5, 6, 2.5, 0.6), 48);
  scene.motion = straight({0, 0, -6}, {0, 0, -6.1}, 1, 1000, 250);
  for (const auto& [voxel, frame] : run(scene).removed) {
    const Vec3i c = scene.bone.voxmap->grid.coord(voxel);
    const Vec3 p = scene.bone.voxmap->grid.center_mm(c) - Vec3(0, 0, -6.1);
    const double distance = scene.tool.profile.nearest({std::hypot(p.x(), p.y()), p.z()}).distance_mm;
    // A touched voxel holds a point, which lies within half a cell's diagonal of the surface.
    EXPECT_LT(std::abs(distance), std::sqrt(3.0) * (0.25 + scene.tool.shell.cell_mm) / 2 + 0.02);
  }
}

TEST_P(EngineAgreement, NoContactNoForce) {
  const Outcome outcome = agreed([](SimulationInput& s) {
    s.motion = straight({0, 0, 60}, {0, 0, 50}, 20, 1000, 250);
  });
  EXPECT_EQ(outcome.totals.contact_frames, 0);
  EXPECT_EQ(outcome.totals.removed_mm3, 0);
  ASSERT_EQ(outcome.report.warnings.size(), 1U);
  EXPECT_NE(outcome.report.warnings[0].find("never touches"), std::string::npos);
}

}  // namespace
}  // namespace reamsim::test::engine_agreement_tests
