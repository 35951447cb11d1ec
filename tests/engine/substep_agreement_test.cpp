// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Substep by substep: which voxels each engine touches, and what they give.
#include <gtest/gtest.h>

#include "sim/engine/common/engine.h"
#include "sim/engine/common/substep.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::substep_agreement_tests {
namespace {

using Sums = std::array<rs_i64, 10>;

/// What one substep gave.
struct Touched {
  Sums sums{};
  RemovedFrames removed;
  bool operator==(const Touched&) const = default;
};

Sums as_array(const SubstepSums& s) {
  return {s.force[0],  s.force[1], s.force[2],     s.torque[0], s.torque[1],
          s.torque[2], s.energy,   s.floor_energy, s.removed,   s.contacts};
}

Touched one_substep(Engine& engine, const SubstepArgs& args) {
  engine.enqueue(args);
  Batch batch = engine.collect();
  EXPECT_EQ(batch.sums.size(), 1U);
  EXPECT_EQ(batch.times.size(), 1U);
  RemovedFrames removed = engine.take_removed();
  std::sort(removed.begin(), removed.end());
  return {as_array(batch.sums.at(0)), removed};
}

SubstepArgs args_at(const SimulationInput& scene, const Substep& substep, const Aabb& voi) {
  return make_args(substep, voi, scene.tool.shell, scene.bone.voxmap->grid, scene.scenario.cutting, false);
}

/// Every substep of the scene's motion, each collected by itself.
std::vector<Touched> all_substeps(const SimulationInput& scene) {
  const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  const double step = scene.scenario.engine.max_step_voxels * scene.bone.voxmap->grid.voxel_mm;
  const Vec3 margin = Vec3::Constant(scene.tool.shell.cell_mm);
  const Aabb tool_box{scene.tool.bounds.min - margin, scene.tool.bounds.max + margin};
  std::vector<Touched> out;
  for (std::size_t k = 1; k < scene.motion.poses.size(); ++k) {
    const ToolPose &a = scene.motion.poses[k - 1], &b = scene.motion.poses[k];
    const int n = count_substeps(a, b, scene.tool, false, step);
    for (int i = 0; i < n; ++i) {
      const Substep substep = make_substep(a, b, double(i) / n, double(i + 1) / n, scene.motion.frame_s(), 1);
      const auto voi =
          broad_phase(tool_box, scene.bone.voxmap->grid.bounds_mm(), bone_from_shell(substep.pose, false).inverse());
      if (voi) out.push_back(one_substep(*engine, args_at(scene, substep, *voi)));
    }
  }
  return out;
}

class SubstepAgreement : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Engines, SubstepAgreement, testing::ValuesIn(kEngines),
                         [](const auto& tested) { return tested.param; });

TEST_P(SubstepAgreement, EverySubstepTouchesTheReferencesVoxels) {
  const auto device = all_substeps(oblique_scene("auto", GetParam()));
  const auto serial = all_substeps(oblique_scene("serial", GetParam()));
  ASSERT_EQ(device.size(), serial.size());
  EXPECT_GT(device.size(), 30U);
  int touching = 0;
  for (std::size_t i = 0; i < device.size(); ++i) {
    EXPECT_EQ(device[i].sums, serial[i].sums) << "substep " << i;
    EXPECT_EQ(device[i].removed, serial[i].removed) << "substep " << i;
    touching += !serial[i].removed.empty();
  }
  EXPECT_GT(touching, 20);
}

TEST_P(SubstepAgreement, AnEmptyVolumeOfInterestTouchesNothing) {
  SimulationInput scene = oblique_scene("auto", GetParam());
  const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  for (const double far : {40.0, -40.0, 1e5, -1e7}) {
    Substep substep;
    substep.pose.position_mm = Vec3(far, 1, 2);
    substep.origin_velocity_mm_s = Vec3(0, 0, -1);
    substep.duration_s = 1e-3;
    const Aabb nothing{scene.tool.bounds.min, scene.tool.bounds.min};
    EXPECT_EQ(one_substep(*engine, args_at(scene, substep, nothing)), Touched{}) << far;
  }
}

}  // namespace
}  // namespace reamsim::test::substep_agreement_tests
