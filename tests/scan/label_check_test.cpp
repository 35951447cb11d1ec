// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Label maps that do not fit their scan, and values that are no HU.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "sim/base/error.h"
#include "sim/scan/ct_import.h"
#include "test_images.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const Vec3 kBall(10, -20, 30);
constexpr double kRadius_mm = 12;

/// A ball of 800 HU in air, with an edge of 1 mm.
double ball_hu(const Vec3& p) {
  return -1000 + 1800 * std::clamp(kRadius_mm - (p - kBall).norm() + 0.5, 0.0, 1.0);
}

bool in_ball(const Vec3& p) {
  return (p - kBall).norm() <= kRadius_mm;
}

class LabelCheck : public ::testing::Test {
 protected:
  LabelCheck() {
    scan_.dims = {40, 40, 40};
    scan_.origin_mm = kBall - Vec3::Constant(19.5);
    scan_.sample(ball_hu);
    write_image<std::int16_t>(scan_, folder_.file("ct.nrrd"));
  }

  FilledVoxmap import(const std::function<bool(const Vec3&)>& is_labelled, bool fill = false) {
    TestImage labels = scan_;
    labels.sample([&](const Vec3& p) { return is_labelled(p) ? 1 : 0; });
    write_image<std::uint8_t>(labels, folder_.file("labels.nii.gz"));
    BoneSettings settings = settings_for(folder_.file("ct.nrrd"), 1);
    settings.ct.label_map = LabelMapSettings{.path = folder_.file("labels.nii.gz"), .label = {"1"}, .fill = fill};
    Diagnostics report;
    FilledVoxmap out = voxmap_from_ct(settings, report);
    warnings_ = report.warnings;
    return out;
  }

  TempFolder folder_;
  TestImage scan_;
  std::vector<std::string> warnings_;
};

TEST_F(LabelCheck, ALabelThatFitsIsNotWarnedOf) {
  import(in_ball);
  EXPECT_THAT(warnings_, IsEmpty());
}

TEST_F(LabelCheck, AHoleIsWarnedOfWithVolumeAndPlaceAndFilledOnRequest) {
  const auto with_hole = [](const Vec3& p) {
    const Vec3 d = (p - kBall).cwiseAbs();
    return in_ball(p) && !(d.x() < 3.5 && d.y() < 3.5);
  };
  const double whole = volume_mm3(import(in_ball)), cut = volume_mm3(import(with_hole));
  ASSERT_LT(cut, 0.9 * whole);
  ASSERT_THAT(warnings_, Contains(HasSubstr("which the label surrounds, have no label")));
  std::smatch found;
  ASSERT_TRUE(
      std::regex_search(warnings_[0], found, std::regex(R"((\d+) mm3 of bone \(\d+ mm3 at \(10\.0, -20\.0, 30\.0\))")))
      << warnings_[0];
  // Both ends of the hole, at the surface, are not surrounded by the label.
  EXPECT_NEAR(std::stod(found[1]), whole - cut, 0.2 * (whole - cut));
  EXPECT_NEAR(volume_mm3(import(with_hole, true)), whole, 0.02 * whole);
  EXPECT_THAT(warnings_, Not(Contains(HasSubstr("have no label"))));
}

TEST_F(LabelCheck, ACavityIsWarnedOf) {
  import([](const Vec3& p) { return in_ball(p) && (p - kBall).norm() > 7;
});
EXPECT_THAT(warnings_, Contains(HasSubstr("at (10.0, -20.0, 30.0)")));
}  // namespace

TEST_F(LabelCheck, PiecesAreWarnedOf) {
  import([](const Vec3& p) { return in_ball(p) && std::abs(p.z() - kBall.z()) > 1;
});
EXPECT_THAT(warnings_, Contains(AllOf(HasSubstr("the label has 2 pieces"), HasSubstr("all are bone"))));
}  // namespace reamsim::test

TEST_F(LabelCheck, ALabelAtTheEdgeOfTheScanIsWarnedOf) {
  scan_.origin_mm = kBall - Vec3(19.5, 19.5, 5.5);
  scan_.sample(ball_hu);
  write_image<std::int16_t>(scan_, folder_.file("ct.nrrd"));
  import(in_ball);
  EXPECT_THAT(warnings_, Contains(HasSubstr("the label ends at the edge of the scan, over")));
}

TEST_F(LabelCheck, ValuesWithAnOffsetAreWarnedOfAndCorrected) {
  Diagnostics report;
  const double right = volume_mm3(voxmap_from_ct(settings_for(folder_.file("ct.nrrd"), 1), report));
  EXPECT_THAT(report.warnings, IsEmpty());
  TestImage offset = scan_;
  for (double& value : offset.value) value += 1024;
  write_image<std::uint16_t>(offset, folder_.file("offset.nii.gz"));
  BoneSettings settings = settings_for(folder_.file("offset.nii.gz"), 1);
  EXPECT_GT(volume_mm3(voxmap_from_ct(settings, report)), 1.05 * right);
  EXPECT_THAT(report.warnings, Contains(HasSubstr("set bone.ct.hu.intercept to -1024")));
  settings.ct.hu = HuSettings{.slope = 1, .intercept = -1024};
  report = {};
  EXPECT_NEAR(volume_mm3(voxmap_from_ct(settings, report)), right, 1e-6 * right);
  EXPECT_THAT(report.warnings, IsEmpty());
}

}  // namespace
}  // namespace reamsim::test
