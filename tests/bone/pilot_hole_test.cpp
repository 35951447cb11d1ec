// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "bone_fixture.h"

namespace reamsim::test {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

FilledVoxmap block() {
  Diagnostics report;
  BoneSettings settings = phantom(PhantomShape::half_space, 0.25);
  settings.phantom.size_mm = {20, 20, 16};
  return bone_from_phantom(settings, report).copy_voxels();
}

TEST(PilotHole, VolumeOfTheCylinder) {
  FilledVoxmap bone = block();
  const double before_mm3 = bone.bone_mm3();
  PilotHoleSettings hole;
  hole.diameter_mm = 5;
  hole.entry_mm = {0, 0, 3};
  hole.depth_mm = 13;  // 3 mm of it in the air
  const double drilled_mm3 = drill_pilot_hole(bone, hole, {});
  const double truth_mm3 = pi * 2.5 * 2.5 * 10;
  EXPECT_NEAR(drilled_mm3, truth_mm3, 0.01 * truth_mm3);
  EXPECT_NEAR(before_mm3 - bone.bone_mm3(), drilled_mm3, 1e-9);
  EXPECT_EQ(grade_at(bone, {0, 0, -9.9}), 0);
  EXPECT_NE(grade_at(bone, {0, 0, -10.2}), 0);
  EXPECT_NE(grade_at(bone, {2.8, 0, -5}), 0);
}

TEST(PilotHole, ObliqueAxisOfAnyLength) {
  FilledVoxmap bone = block();
  PilotHoleSettings hole;
  hole.diameter_mm = 4;
  hole.entry_mm = {-5, 0, -8};
  hole.axis = {5, 0, -2};
  hole.depth_mm = 8;
  const double truth_mm3 = pi * 4 * 8;
  EXPECT_NEAR(drill_pilot_hole(bone, hole, {}), truth_mm3, 0.02 * truth_mm3);
}

TEST(PilotHole, CountsOnlyWhatIsLeft) {
  FilledVoxmap bone = block();
  const Vec3i voxel = bone.grid.voxel_of({0.1, 0.1, -5.1});
  bone.fill.set(voxel, 0);
  FilledVoxmap whole = block();
  PilotHoleSettings hole;
  EXPECT_NEAR(drill_pilot_hole(whole, hole, {}) - drill_pilot_hole(bone, hole, {}), 0.25 * 0.25 * 0.25, 1e-9);
}

TEST(PilotHole, InTheGlenoidFrame) {
  FilledVoxmap bone = block();
  GlenoidFrame frame;
  frame.bone_from_glenoid.linear() << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // +z of G is +x of B
  frame.bone_from_glenoid.translation() = Vec3(10, 0, -8);
  PilotHoleSettings hole;
  hole.frame = PoseFrame::glenoid;
  hole.diameter_mm = 3;
  hole.depth_mm = 6;
  EXPECT_GT(drill_pilot_hole(bone, hole, frame), 40);
  EXPECT_EQ(grade_at(bone, {5, 0, -8}), 0);
  EXPECT_NE(grade_at(bone, {3, 0, -8}), 0);
}

TEST(PilotHole, FarAwayMeetsNothing) {
  FilledVoxmap bone = block();
  PilotHoleSettings hole;
  hole.entry_mm = {1e12, -1e12, 1e12};
  EXPECT_EQ(drill_pilot_hole(bone, hole, {}), 0);
}

TEST(PilotHole, NeedsAFrame) {
  FilledVoxmap bone = block();
  PilotHoleSettings hole;
  hole.frame = PoseFrame::glenoid;
  EXPECT_THAT(input_error([&] { drill_pilot_hole(bone, hole, {}); }), HasSubstr("bone.pilot_hole.frame"));
}

}  // namespace
}  // namespace reamsim::test
