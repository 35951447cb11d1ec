// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bone_fixture.h"

namespace reamsim::test {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

TEST(HalfSpace, IsTheBlockExactly) {
  BoneSettings settings = phantom(PhantomShape::half_space, 0.25);
  settings.phantom.size_mm = {10, 12, 5};
  settings.phantom.density_g_cm3 = 1.8;
  const Bone bone = make(settings);
  EXPECT_DOUBLE_EQ(bone.view().bone_mm3(), 10 * 12 * 5);
  EXPECT_EQ(bone.voxmap->frame, "phantom");
  EXPECT_EQ(grade_at(bone, {0, 0, -0.01}), 225);
  EXPECT_EQ(grade_at(bone, {0, 0, 0.01}), 0);
  EXPECT_EQ(grade_at(bone, {4.99, 5.99, -4.99}), 225);
  EXPECT_EQ(grade_at(bone, {5.01, 0, -1}), 0);
  EXPECT_EQ(bone.voxmap->grid.dims.x() % 8, 0);
}

TEST(HalfSpace, GlenoidFrameStandsOnTheTopFace) {
  const Bone bone = make(phantom(PhantomShape::half_space, 1));
  ASSERT_TRUE(bone.glenoid);
  EXPECT_TRUE(bone.glenoid->bone_from_glenoid.isApprox(Rigid::Identity()));
}

TEST(HalfSpace, MarrowIsNotAir) {
  BoneSettings settings = phantom(PhantomShape::half_space, 1);
  settings.phantom.density_g_cm3 = 0;
  EXPECT_EQ(grade_at(make(settings), {0, 0, -1}), 1);
}

TEST(HalfSpace, LatticeThatCannotFit) {
  const std::string text = input_error([] { make(phantom(PhantomShape::half_space, 1e-4)); });
  EXPECT_THAT(text, HasSubstr("would fit"));
  EXPECT_THAT(text, HasSubstr("bone.voxel_mm of "));
}

TEST(Cup, TakesTheCapOutOfTheBlock) {
  BoneSettings settings = phantom(PhantomShape::cup, 0.2);
  settings.phantom.size_mm = {32, 32, 8};
  settings.phantom.radius_mm = 20;
  settings.phantom.cup_depth_mm = 4;
  const Bone bone = make(settings);
  const double cap_mm3 = pi * 4 * 4 * (3 * 20 - 4) / 3;
  EXPECT_NEAR(bone.view().bone_mm3(), 32 * 32 * 8 - cap_mm3, 0.005 * cap_mm3);
  EXPECT_EQ(grade_at(bone, {0, 0, -3.8}), 0);
  EXPECT_NE(grade_at(bone, {0, 0, -4.2}), 0);
  for (const Vec2& away : {Vec2(6, 0), Vec2(-6, 0), Vec2(0, 6), Vec2(0, -6)}) {
    const double bottom_mm = (20 - 4) - std::sqrt(20 * 20 - away.squaredNorm());
    EXPECT_EQ(grade_at(bone, {away.x(), away.y(), bottom_mm + 0.2}), 0) << away.transpose();
    EXPECT_NE(grade_at(bone, {away.x(), away.y(), bottom_mm - 0.2}), 0) << away.transpose();
  }
}

TEST(Cup, ItsRimLiesOnTheTopFaceAndTheSphere) {
  BoneSettings settings = phantom(PhantomShape::cup, 0.5);
  settings.phantom.cup_depth_mm = 4;
  const Bone bone = make(settings);
  ASSERT_GE(bone.rim_mm.size(), 100u);
  for (const Vec3& point : bone.rim_mm) {
    EXPECT_EQ(point.z(), 0);
    EXPECT_NEAR((point - Vec3(0, 0, settings.phantom.radius_mm - 4)).norm(), settings.phantom.radius_mm, 1e-9);
  }
}

TEST(Sphere, VolumeAndPole) {
  BoneSettings settings = phantom(PhantomShape::sphere, 0.25);
  settings.phantom.radius_mm = 10;
  const Bone bone = make(settings);
  const double truth_mm3 = 4.0 / 3 * pi * 1000;
  EXPECT_NEAR(bone.view().bone_mm3(), truth_mm3, 0.002 * truth_mm3);
  ASSERT_TRUE(bone.glenoid);
  EXPECT_NEAR((bone.glenoid->bone_from_glenoid.translation() - Vec3(0, 0, 10)).norm(), 0, 1e-12);
}

TEST(Layered, CorticalOnTrabecular) {
  BoneSettings settings = phantom(PhantomShape::layered, 0.25);
  settings.phantom.size_mm = {8, 8, 10};
  settings.phantom.cortical_mm = 2;
  const FilledVoxmap voxmap = make(settings).copy_voxels();
  const std::int64_t cortical = count_grade(voxmap, 225);
  const std::int64_t trabecular = count_grade(voxmap, 50);
  EXPECT_EQ(cortical, 32 * 32 * 8);
  EXPECT_EQ(trabecular, 32 * 32 * 32);
  EXPECT_EQ(grade_at(voxmap, {0, 0, -1.9}), 225);
  EXPECT_EQ(grade_at(voxmap, {0, 0, -2.1}), 50);
}

}  // namespace
}  // namespace reamsim::test
