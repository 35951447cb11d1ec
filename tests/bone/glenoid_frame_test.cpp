// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bone_fixture.h"
#include "sim/bone/bone.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

GlenoidSettings directions(const Vec3& center, const Vec3& normal, const Vec3& superior) {
  GlenoidSettings out;
  out.center_mm = center;
  out.normal = normal;
  out.superior = superior;
  return out;
}

TEST(GlenoidFrame, NoneWhereNoneIsGiven) {
  EXPECT_FALSE(glenoid_frame({}, BodySide::unknown));
}

TEST(GlenoidFrame, SuperiorIsMadePerpendicular) {
  const auto frame = glenoid_frame(directions({1, 2, 3}, {2, 0, 0}, {5, 0, 3}), BodySide::left);
  ASSERT_TRUE(frame);
  const Mat3 axes = frame->bone_from_glenoid.linear();
  EXPECT_NEAR((axes.col(2) - Vec3::UnitX()).norm(), 0, 1e-12);
  EXPECT_NEAR((axes.col(1) - Vec3::UnitZ()).norm(), 0, 1e-12);
  EXPECT_NEAR((axes.col(0) - Vec3::UnitY()).norm(), 0, 1e-12);  // posterior on a left scapula in LPS
  EXPECT_NEAR(axes.determinant(), 1, 1e-12);
  EXPECT_EQ(frame->bone_from_glenoid.translation(), Vec3(1, 2, 3));
}

TEST(GlenoidFrame, RightSideLooksAnteriorAlongX) {
  const auto frame = glenoid_frame(directions(Vec3::Zero(), {-1, 0, 0}, {0, 0, 1}), BodySide::right);
  EXPECT_NEAR((frame->bone_from_glenoid.linear().col(0) - Vec3(0, -1, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR(frame->bone_from_glenoid.linear().determinant(), 1, 1e-12);
}

TEST(GlenoidFrame, FromLandmarksOnBothSides) {
  for (const double lateral : {1.0, -1.0}) {  // left, right in LPS
    GlenoidSettings settings;
    settings.landmarks = LandmarkSettings{{100 * lateral, 5, 0}, {0, 5, 0}, {20 * lateral, 5, -110}};
    const auto frame = glenoid_frame(settings, lateral > 0 ? BodySide::left : BodySide::right);
    ASSERT_TRUE(frame);
    const Mat3 axes = frame->bone_from_glenoid.linear();
    EXPECT_NEAR((axes.col(2) - Vec3(lateral, 0, 0)).norm(), 0, 1e-12);
    EXPECT_NEAR((axes.col(1) - Vec3(0, 0, 1)).norm(), 0, 1e-12);
    EXPECT_NEAR((axes.col(0) - Vec3(0, lateral, 0)).norm(), 0, 1e-12);
    EXPECT_EQ(frame->bone_from_glenoid.translation(), Vec3(100 * lateral, 5, 0));
  }
}

TEST(GlenoidFrame, NeedsASide) {
  const GlenoidSettings settings = directions(Vec3::Zero(), {1, 0, 0}, {0, 0, 1});
  EXPECT_THAT(input_error([&] { glenoid_frame(settings, BodySide::unknown); }), HasSubstr("bone.side: missing"));
}

TEST(GlenoidFrame, NeedsAllThree) {
  GlenoidSettings settings = directions(Vec3::Zero(), {1, 0, 0}, {0, 0, 1});
  settings.center_mm.reset();
  EXPECT_THAT(input_error([&] { glenoid_frame(settings, BodySide::left); }),
              HasSubstr("bone.glenoid.center_mm: missing"));
  settings = directions(Vec3::Zero(), {1, 0, 0}, {0, 0, 1});
  settings.normal.reset();
  EXPECT_THAT(input_error([&] { glenoid_frame(settings, BodySide::left); }), HasSubstr("bone.glenoid.normal: missing"));
  settings = directions(Vec3::Zero(), {1, 0, 0}, {0, 0, 1});
  settings.superior.reset();
  EXPECT_THAT(input_error([&] { glenoid_frame(settings, BodySide::left); }),
              HasSubstr("bone.glenoid.superior: missing"));
}

TEST(GlenoidFrame, RefusesZeroParallelAndCollinear) {
  const auto text = [](const GlenoidSettings& settings) {
    return input_error([&] { glenoid_frame(settings, BodySide::left); });
  };
  EXPECT_THAT(text(directions(Vec3::Zero(), {0, 0, 0}, {0, 0, 1})), HasSubstr("of length 0"));
  EXPECT_THAT(text(directions(Vec3::Zero(), {1, 0, 0}, {0, 0, 0})), HasSubstr("of length 0"));
  EXPECT_THAT(text(directions(Vec3::Zero(), {1, 0, 0}, {-3, 0, 0.001})), HasSubstr("parallel"));
  GlenoidSettings settings;
  settings.landmarks = LandmarkSettings{{10, 0, 0}, {0, 0, 0}, {-20, 0, 0}};
  EXPECT_THAT(text(settings), HasSubstr("line"));
  settings.landmarks->trigonum_spinae_mm = {10, 0, 0};
  EXPECT_THAT(text(settings), HasSubstr("trigonum_spinae_mm"));
  settings.center_mm = Vec3::Zero();
  EXPECT_THAT(text(settings), HasSubstr("directions and landmarks"));
}

}  // namespace
}  // namespace reamsim::test
