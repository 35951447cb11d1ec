// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/scan/ct_import.h"
#include "test_images.h"

namespace reamsim::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

double ball(double radius) {
  return 4.0 / 3 * std::numbers::pi * std::pow(radius, 3);
}

/// HU across the surface of something of 700 HU, blurred over about 1 mm; 350 at the surface.
double edge(double depth) {
  return 350 * (1 + std::tanh(depth / 0.6));
}

class RefineMask : public ::testing::Test {
 protected:
  /// A CT of `hu` at 0.5 mm and a mask of what lies within `mask_radius`, on voxels of 1 mm.
  BoneSettings write(const std::function<double(const Vec3&)>& hu, const std::function<double(const Vec3&)>& mask) {
    TestImage image;
    image.dims = {64, 52, 52};
    image.spacing_mm = Vec3::Constant(0.5);
    image.origin_mm = Vec3::Constant(-12.75);
    image.sample(hu);
    write_image<std::int16_t>(image, folder_.file("ct.nrrd"));
    image.dims /= 2;
    image.spacing_mm *= 2;
    image.origin_mm += Vec3::Constant(0.25);
    image.sample(mask);
    write_image<std::uint8_t>(image, folder_.file("mask.nrrd"));
    BoneSettings out = settings_for(folder_.file("ct.nrrd"), 0.5);
    out.surface_voxels = SurfaceVoxels::partial;
    out.ct.label_map = LabelMapSettings{.path = folder_.file("mask.nrrd"), .label = {"1"}};
    out.ct.label_map->refine_hu = 350;
    return out;
  }
  double volume(BoneSettings settings, double refine_mm) {
    settings.ct.label_map->refine_mm = refine_mm;
    report_ = {};
    return voxmap_from_ct(settings, report_).bone_mm3();
  }

  TempFolder folder_;
  Diagnostics report_;
};

TEST_F(RefineMask, TheSurfaceBecomesTheIsosurface) {
  const auto hu = [](const Vec3& p) { return edge(8 - p.norm()); };
  for (const double mask_radius : {7.4, 8.0, 8.6}) {
    const BoneSettings settings = write(hu, [=](const Vec3& p) { return p.norm() < mask_radius ? 1 : 0; });
    EXPECT_NEAR(volume(settings, 0) / ball(mask_radius), 1, 0.03) << mask_radius;
    EXPECT_NEAR(volume(settings, 1) / ball(8), 1, 0.01) << mask_radius;
    EXPECT_THAT(report_.notes, Contains(HasSubstr("refined to the 350 HU isosurface within 1 mm: ")));
  }
}

TEST_F(RefineMask, BeyondItsReachTheMaskStays) {
  const auto hu = [](const Vec3& p) { return edge(8 - p.norm()); };
  const BoneSettings settings = write(hu, [](const Vec3& p) { return p.norm() < 5 ? 1 : 0; });
  // Dense on both sides, further than the refinement reaches.
  EXPECT_NEAR(volume(settings, 1) / volume(settings, 0), 1, 0.03);
}

TEST_F(RefineMask, TrabecularBoneUnderTheCortexStays) {
  // A cortex of 1 mm: below the threshold begins within reach of the surface.
  const auto hu = [](const Vec3& p) { return edge(8 - p.norm()) - 0.85 * edge(6.8 - p.norm()); };
  const BoneSettings settings = write(hu, [](const Vec3& p) { return p.norm() < 8 ? 1 : 0; });
  const double mask = volume(settings, 0);
  EXPECT_NEAR(volume(settings, 1.5) / mask, 1, 0.04);
  BoneSettings one = settings;
  one.ct.label_map->refine_mm = 1.5;
  const FilledVoxmap voxmap = voxmap_from_ct(one, report_);
  for (const double radius : {0.0, 3.0, 5.5, 6.5, 7.0}) EXPECT_NE(grade_at(voxmap, Vec3(0, radius, 0)), 0) << radius;
}

TEST_F(RefineMask, ANeighbourAcrossAGapIsNotTaken) {
  // A second bone 1 mm away, labelled or not; the gap falls below the threshold.
  const auto second = [](const Vec3& p) { return 5 - (p - Vec3(14, 0, 0)).norm(); };
  const auto hu = [=](const Vec3& p) { return std::max(edge(8 - p.norm()), edge(second(p))); };
  for (const double label : {0.0, 2.0}) {
    const BoneSettings settings =
        write(hu, [=](const Vec3& p) { return p.norm() < 7.6 ? 1 : (second(p) > 0 ? label : 0); });
    EXPECT_NEAR(volume(settings, 1) / ball(8), 1, 0.01) << label;
    BoneSettings one = settings;
    one.ct.label_map->refine_mm = 1;
    EXPECT_EQ(grade_at(voxmap_from_ct(one, report_), Vec3(9.6, 0, 0)), 0) << label;
  }
}

}  // namespace
}  // namespace reamsim::test
