// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// A CT's voxels at the surface hold bone and what is beside it: their fill says how much, their density is the bone's.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>

#include "sim/scan/ct_import.h"
#include "test_images.h"

namespace reamsim::test {
namespace {

using std::numbers::pi;

constexpr double kBone_hu = 1000;
constexpr double kWater_hu = 0;
const Vec3 kCenter_mm(0.21, -0.17, 0.33);
constexpr double kRadius_mm = 9;
constexpr double kSpacing_mm = 0.5;

/// The mean of bone and water over a scanner's voxel.
double blurred_edge(const Vec3& p) {
  constexpr int kPerAxis = 8;
  const double away = (p - kCenter_mm).norm() - kRadius_mm;
  if (std::abs(away) > 0.9 * kSpacing_mm) return away < 0 ? kBone_hu : kWater_hu;
  int bone = 0;
  for (int i = 0; i < kPerAxis * kPerAxis * kPerAxis; ++i) {
    const Vec3 step(i % kPerAxis, i / kPerAxis % kPerAxis, i / kPerAxis / kPerAxis);
    const Vec3 at = p + kSpacing_mm * ((step + Vec3::Constant(0.5)) / kPerAxis - Vec3::Constant(0.5));
    bone += (at - kCenter_mm).norm() < kRadius_mm ? 1 : 0;
  }
  return kWater_hu + (kBone_hu - kWater_hu) * bone / std::pow(kPerAxis, 3);
}

class PartialCt : public ::testing::Test {
 protected:
  FilledVoxmap import(double voxel_mm, SurfaceVoxels surface_voxels) {
    TestImage image;
    image.dims = {50, 50, 50};
    image.spacing_mm = Vec3::Constant(kSpacing_mm);
    image.origin_mm = Vec3(-12.4, -12.7, -12.3);
    image.sample(blurred_edge);
    write_image<float>(image, folder_.file("ball.nrrd"));
    settings_ = settings_for(folder_.file("ball.nrrd"), voxel_mm);
    settings_.ct.threshold_hu = (kBone_hu + kWater_hu) / 2;
    settings_.surface_voxels = surface_voxels;
    return voxmap_from_ct(settings_, report_);
  }

  static constexpr double kTruth_mm3 = 4 * pi / 3 * kRadius_mm * kRadius_mm * kRadius_mm;
  TempFolder folder_;
  BoneSettings settings_;
  Diagnostics report_;
};

/// Bone mineral mass, mg, of the fill with its density.
double mass_mg(const FilledVoxmap& voxmap) {
  double sum = 0;
  for_each_bone_voxel(voxmap, [&](const Vec3i&, std::uint8_t grade, std::uint16_t fill) {
    sum += DensityMapping::density_from_grade(grade) * fill / FillBricks::kWhole * voxmap.grid.voxel_mm3();
  });
  return sum;
}

TEST_F(PartialCt, NeitherVolumeNorDensityCountsTheAirTwice) {
  const std::uint8_t bone = DensityMapping::grade_from_density(DensityMapping().density_from_hu(kBone_hu));
  const double truth_mg = kTruth_mm3 * DensityMapping::density_from_grade(bone);
  const FilledVoxmap partial = import(kSpacing_mm, SurfaceVoxels::partial),
                     whole = import(kSpacing_mm, SurfaceVoxels::whole);
  std::cout << "volume " << 100 * (partial.bone_mm3() / kTruth_mm3 - 1) << " %, whole voxels "
            << 100 * (whole.bone_mm3() / kTruth_mm3 - 1) << " %; mass " << 100 * (mass_mg(partial) / truth_mg - 1)
            << " %, whole voxels " << 100 * (mass_mg(whole) / truth_mg - 1) << " %\n";
  // Interpolation between voxels takes 1/(2 R²) of a ball of R voxels; the density is right.
  EXPECT_NEAR(partial.bone_mm3() / kTruth_mm3, 1, 0.003);
  EXPECT_NEAR(mass_mg(partial) / truth_mg, partial.bone_mm3() / kTruth_mm3, 1e-4);
  EXPECT_NEAR(mass_mg(whole) / truth_mg, whole.bone_mm3() / kTruth_mm3, 1e-4);
}

TEST_F(PartialCt, BoundaryVoxelsHaveTheDensityOfTheirFullNeighbours) {
  const std::uint8_t bone = DensityMapping::grade_from_density(DensityMapping().density_from_hu(kBone_hu));
  const FilledVoxmap partial = import(kSpacing_mm, SurfaceVoxels::partial);
  std::int64_t boundary = 0, thinned = 0;
  for_each_bone_voxel(partial, [&](const Vec3i&, std::uint8_t grade, std::uint16_t fill) {
    boundary += fill != FillBricks::kWhole ? 1 : 0;
    thinned += grade < bone - 2 ? 1 : 0;
  });
  EXPECT_GT(boundary, 1000);
  EXPECT_LT(thinned, boundary / 50);
}

TEST_F(PartialCt, VolumeHoldsWhetherVoxelsMergeOrDivide) {
  for (const double voxel_mm : {0.2, 0.35, 0.8, 1.25}) {
    const FilledVoxmap partial = import(voxel_mm, SurfaceVoxels::partial);
    std::cout << voxel_mm << " mm: volume " << 100 * (partial.bone_mm3() / kTruth_mm3 - 1) << " %\n";
    EXPECT_NEAR(partial.bone_mm3() / kTruth_mm3, 1, 0.004) << voxel_mm;
  }
}

TEST_F(PartialCt, CutsPassThroughVoxels) {
  import(kSpacing_mm, SurfaceVoxels::partial);
  settings_.ct.cut_planes.push_back({kCenter_mm, Vec3(1, 2, -2) / 3});
  EXPECT_NEAR(voxmap_from_ct(settings_, report_).bone_mm3() / (kTruth_mm3 / 2), 1, 0.004);
  settings_.ct.cut_planes.clear();
  settings_.ct.cut_spheres.push_back({kCenter_mm, 6});
  EXPECT_NEAR(voxmap_from_ct(settings_, report_).bone_mm3() / (kTruth_mm3 - 4 * pi / 3 * 216), 1, 0.004);
}

TEST_F(PartialCt, ACortexOfOneVoxelKeepsItsDensity) {
  TestImage image;
  image.dims = {26, 26, 26};
  image.origin_mm = Vec3(-12.4, -12.7, -12.3);
  image.sample([](const Vec3& p) {
    const double r = (p - kCenter_mm).norm();
    return r > 9.5 ? -50 : r > 8.5 ? 1200 : 250;
  });
  write_image<float>(image, folder_.file("shell.nrrd"));
  settings_ = settings_for(folder_.file("shell.nrrd"), 1);
  const FilledVoxmap whole = voxmap_from_ct(settings_, report_);
  settings_.surface_voxels = SurfaceVoxels::partial;
  const FilledVoxmap partial = voxmap_from_ct(settings_, report_);
  for_each_bone_voxel(whole, [&](const Vec3i& voxel, std::uint8_t grade, std::uint16_t) {
    const std::uint8_t now = partial.grade.get(voxel);
    EXPECT_TRUE(now == 0 || now >= grade) << int{now} << " instead of " << int{grade};
  });
}

}  // namespace
}  // namespace reamsim::test
