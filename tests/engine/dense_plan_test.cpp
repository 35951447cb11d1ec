// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The published memory layouts, and what happens when they do not fit.
#include "sim/engine/common/engine.h"
#include "sim/engine/dense/dense_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::dense_plan_tests {
namespace {

using testing::HasSubstr;

cl::DeviceInfo device_with(std::size_t memory, std::size_t allocation) {
  cl::DeviceInfo info;
  info.name = "a card";
  info.global_memory_bytes = memory;
  info.max_allocation_bytes = allocation;
  return info;
}

std::string refusal(const DensePlan& plan, const cl::DeviceInfo& device) {
  try {
    require_fit(plan, device, 0.2);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(DensePlan, KeepsThePublishedLayouts) {
  const SimulationInput scene = oblique_scene("auto");
  const std::size_t voxels = 41 * 37 * 29, points = scene.tool.shell.codes.size();
  const auto plan = [&](EngineKind engine) { return plan_dense(engine, scene.bone, scene.tool, false); };
  EXPECT_EQ(plan(EngineKind::direct).bone_bytes(), voxels);
  EXPECT_EQ(plan(EngineKind::direct).shell_bytes(), 4 * points);
  EXPECT_EQ(plan(EngineKind::octree).bone_bytes(), 4 * voxels);
  EXPECT_NEAR(double(plan(EngineKind::octree).claim_bytes()), double(voxels), 4);
  EXPECT_EQ(plan(EngineKind::octree).shell_bytes(), 12 * points);
  EXPECT_EQ(plan(EngineKind::implicit).bone_bytes(), voxels);
  EXPECT_EQ(plan(EngineKind::implicit).claim_bytes(), 0U);
  EXPECT_EQ(plan(EngineKind::implicit).shell_bytes(), 0U);
}

TEST(DensePlan, SaysWhatWouldFit) {
  const SimulationInput scene = oblique_scene("auto");
  for (const EngineKind engine : {EngineKind::direct, EngineKind::octree, EngineKind::implicit}) {
    SCOPED_TRACE(name_of(engine));
    const DensePlan plan = plan_dense(engine, scene.bone, scene.tool, true);
    EXPECT_EQ(refusal(plan, device_with(plan.bytes(), plan.largest_bytes())), "");
    for (const auto& small :
         {device_with(plan.bytes() - 1, plan.bytes()), device_with(plan.bytes(), plan.largest_bytes() - 1)}) {
      EXPECT_THAT(refusal(plan, small), HasSubstr("bone.voxel_mm: found a voxmap of 43993 voxels"));
      EXPECT_THAT(refusal(plan, small), HasSubstr("a bone.voxel_mm of about 0.204 or more would fit"));
      EXPECT_THAT(refusal(plan, small), HasSubstr("engine.type: bricked"));
    }
    const auto eighth = device_with(plan.bytes() / 8, plan.bytes());
    EXPECT_THAT(refusal(plan, eighth), HasSubstr("of about 0.408 or more"));
  }
}

TEST(DensePlan, VoxelsAreNumberedIn32Bits) {
  DensePlan plan;
  plan.voxels = std::size_t{1} << 32;
  const std::size_t plenty = std::size_t{1} << 50;
  EXPECT_EQ(refusal(plan, device_with(plenty, plenty)), "");
  plan.voxels += 1;
  EXPECT_THAT(refusal(plan, device_with(plenty, plenty)), HasSubstr("a dense engine supports at most 4294967296"));
}

TEST(DensePlan, TheContactListHoldsWhateverTheToolCanHold) {
  SimulationInput scene = oblique_scene("serial", "implicit");
  scene.bone.set_voxels(block({16, 16, 16}, 0.25, 1.0));
  const DensePlan plan = plan_dense(EngineKind::implicit, scene.bone, scene.tool, false);
  EXPECT_LT(plan.contacts, plan.bone_voxels);
  // Jumps right inside, turned so that the box's diagonals lie along the lattice.
  const Quat turn(Eigen::AngleAxisd(0.7, Vec3(1, 1, 0).normalized()));
  scene.motion = straight({0, 0, -7}, {0, 0, -7.1}, 1, 1000, 250, turn);
  const Outcome outcome = run(scene);
  EXPECT_GT(outcome.removed.size(), plan.contacts / 4);
  EXPECT_LE(outcome.removed.size(), plan.contacts);
}

TEST(Octree, LevelsAndTables) {
  const auto levels = [](int x, int y, int z) { return octree_levels({{x, y, z}, 1, Vec3::Zero()}); };
  EXPECT_EQ(levels(1, 1, 1), 0);
  EXPECT_EQ(levels(2, 1, 1), 1);
  EXPECT_EQ(levels(3, 5, 4), 3);
  EXPECT_EQ(levels(1024, 7, 1024), 10);
  EXPECT_EQ(levels(7, 1025, 1), 11);
  const auto children = octree_children({{5, 3, 2}, 1, Vec3::Zero()});
  ASSERT_EQ(children.size(), 24U);
  EXPECT_EQ(children[0].s[3], 0U);
  EXPECT_EQ(children[1].s[0], 4U);          // root, octant +x
  EXPECT_EQ(children[8 + 2].s[3], 5U * 2);  // level 1, octant +y: two rows
  EXPECT_EQ(children[16 + 4].s[3], 15U);    // level 2, octant +z: one layer
  EXPECT_EQ(children[16 + 7].s[3], 1U + 5 + 15);
}

TEST(HuScale, EveryGradeComesBackFromItsHu) {
  EXPECT_TRUE(HuScale(DensityMapping{}).exact());
  DensityMapping steep;
  steep.ash_slope_g_cm3_per_hu = 0.01;
  steep.ash_offset_g_cm3 = 0.1;
  EXPECT_TRUE(HuScale(steep).exact());
  DensityMapping lost;  // HU of a hundred million, a unit apart
  lost.ash_slope_g_cm3_per_hu = 0.005;
  lost.ash_offset_g_cm3 = -1e6;
  EXPECT_FALSE(HuScale(lost).exact());
  SimulationInput scene = oblique_scene("auto", "octree");
  FilledVoxmap voxels = scene.bone.copy_voxels();
  voxels.mapping = lost;
  scene.bone.set_voxels(std::move(voxels));
  EXPECT_THROW(make_engine(scene.scenario, scene.bone, scene.tool), InputError);
}

}  // namespace
}  // namespace reamsim::test::dense_plan_tests
