// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Version by each definition, from points in closed form, and from those of SciKit-SurgeryGlenoid.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "sim/bone/bone.h"
#include "sim/scenario/markups.h"
#include "tests/anatomy/reamed_fixture.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

std::map<std::string, Measured<double>> versions_of(const BoneAxes& axes) {
  std::map<std::string, Measured<double>> out;
  for (const FaceVersion& version : measure_versions(Missing{"no rim"}, axes)) out[version.name] = version.deg;
  return out;
}

/// A face with version v and inclination i: two planes gives asin(sin v cos i), a slice across it atan(tan v).
TEST(Version, PointsOfAKnownFace) {
  for (const double v : {-12.0, 25.0}) {
    for (const double side : {-1.0, 1.0}) {  // a left and a right bone: anterior is -y, lateral +-x
      const double i = 8 * kDegree;
      const Vec3 lateral(side, 0, 0), anterior(0, -1, 0), superior(0, 0, 1), center(3, -40, 7);
      const Vec3 normal = std::cos(v * kDegree) * std::cos(i) * lateral + std::sin(i) * superior -
                          std::sin(v * kDegree) * std::cos(i) * anterior;
      const Vec3 along = (std::sin(v * kDegree) * lateral + std::cos(v * kDegree) * anterior);  // in face and slice
      const Vec3 up = normal.cross(along);
      BoneAxes axes{.scapula = ScapularAxes{lateral, superior, anterior}, .glenoid = {}};
      axes.version = {.face_mm = {center + 15 * up, center - 14 * up + 9 * along, center - 14 * up - 9 * along},
                      .anterior_margin_mm = center + 12 * along,
                      .posterior_margin_mm = center - 12 * along,
                      .medial_tip_mm = center - 100 * lateral,
                      .vault_tip_mm = center - 30 * (lateral + std::tan(5 * kDegree) * anterior)};
      const auto found = versions_of(axes);
      EXPECT_NEAR(*found.at("two_planes").value, std::asin(std::sin(v * kDegree) * std::cos(i)) / kDegree, 1e-9);
      EXPECT_NEAR(*found.at("friedman_2d").value, v, 1e-9);
      EXPECT_NEAR(*found.at("vault_2d").value, v + 5, 1e-9);
      EXPECT_FALSE(found.at("face_axis").value);
      EXPECT_EQ(found.at("face_axis").reason, "no rim");
    }
  }
}

TEST(Version, SaysWhichPointsAreMissing) {
  BoneAxes axes;
  axes.version.face_mm = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  auto found = versions_of(axes);
  EXPECT_EQ(found.at("two_planes").reason, "landmarks are missing: set bone.glenoid.landmarks");
  EXPECT_EQ(found.at("vault_2d").reason,
            "landmarks are missing: set bone.glenoid.version_landmarks.anterior_margin_mm, "
            "bone.glenoid.version_landmarks.posterior_margin_mm, bone.glenoid.version_landmarks.vault_tip_mm");
  axes.scapula.emplace();  // +z is anterior
  axes.side_known = true;
  axes.version.anterior_margin_mm = Vec3(0, 0, -12);
  axes.version.posterior_margin_mm = Vec3(0, 0, 12);
  axes.version.medial_tip_mm = Vec3(-100, 0, 0);
  found = versions_of(axes);
  EXPECT_THAT(found.at("two_planes").reason, HasSubstr("face_mm lie on one line"));
  EXPECT_THAT(found.at("friedman_2d").reason, HasSubstr("anterior_margin_mm lies posterior to posterior_margin_mm"));
  axes.version.posterior_margin_mm = Vec3(0, 0, -11.5);
  EXPECT_THAT(versions_of(axes).at("friedman_2d").reason, HasSubstr("less than 1 mm apart"));
  axes.version.posterior_margin_mm = Vec3(0, 0, -36);
  axes.version.medial_tip_mm = Vec3(0.5, 0, -24);  // at the middle of the margins
  EXPECT_THAT(versions_of(axes).at("friedman_2d").reason, HasSubstr("less than 1 mm apart"));
  axes.axial_z = true;
  axes.version.medial_tip_mm = Vec3(-100, 0, -24);
  EXPECT_THAT(versions_of(axes).at("friedman_2d").reason, HasSubstr("one axial slice"));
}

/// Points and expected versions: github.com/SciKit-Surgery/glenoidplanefitting, commit 9c770a9 (BSD 3-clause),
/// tests/test_glenoidplanefitting_demo.py.
TEST(Version, PublishedPointsOfARightGlenoid) {
  const std::string folder = data_file("glenoid_landmarks/");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder << "; set REAMSIM_DATA";
  const std::vector<Vec3> points = read_markups(folder + "landmark_points.fcsv").positions_mm();
  const std::vector<Vec3> slice = read_markups(folder + "landmark_friedman.fcsv").positions_mm();
  const std::vector<Vec3> vault = read_markups(folder + "landmark_vault.fcsv").positions_mm();
  ASSERT_EQ(points.size(), 6u);
  ASSERT_EQ(slice.size(), 4u);
  ASSERT_EQ(vault.size(), 3u);
  GlenoidSettings marks;
  marks.landmarks = {.glenoid_center_mm = points[3], .trigonum_spinae_mm = points[4], .inferior_angle_mm = points[5]};
  BoneAxes axes;
  axes.scapula = axes_of(*glenoid_frame(marks, BodySide::right), BodySide::right);
  axes.side_known = axes.axial_z = true;
  axes.version = {.face_mm = {points.begin(), points.begin() + 3},
                  .anterior_margin_mm = slice[1],
                  .posterior_margin_mm = slice[0],
                  .medial_tip_mm = slice[2],
                  .vault_tip_mm = vault[2]};
  const auto found = versions_of(axes);
  EXPECT_NEAR(*found.at("two_planes").value, 7.35087724, 1e-6);
  EXPECT_NEAR(*found.at("friedman_2d").value, 7.742736667, 1e-6);
  EXPECT_NEAR(*found.at("vault_2d").value, 15.34696463, 1e-6);
  axes.scapula = axes_of(*glenoid_frame(marks, BodySide::left), BodySide::left);
  EXPECT_NEAR(*versions_of(axes).at("two_planes").value, -7.35087724, 1e-6) << "the sign needs the side";
}

}  // namespace
}  // namespace reamsim::test
