// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/scan/aligned_image.h"
#include "sim/scan/ct_import.h"
#include "test_images.h"

namespace reamsim::test {
namespace {

using ct::AlignedImage;
using ct::SliceResampler;

AlignedImage sampled(const Vec3i& dims, const Vec3& spacing, const std::function<double(const Vec3&)>& function) {
  AlignedImage image;
  image.lattice = {dims, spacing, Vec3(3, -7, 11)};
  for (int k = 0; k < dims.z(); ++k) {
    for (int j = 0; j < dims.y(); ++j) {
      for (int i = 0; i < dims.x(); ++i) {
        image.value.push_back(static_cast<float>(function(image.lattice.center_mm({i, j, k}))));
      }
    }
  }
  return image;
}

double ramp(const Vec3& p) {
  return 20 * p.x() - 35 * p.y() + 50 * p.z() + 8;
}

/// A grid that lies inside the image by a voxel or more, so that its edge plays no part.
VoxelGrid grid_inside(const AlignedImage& image, double voxel_mm) {
  const Vec3 room = image.lattice.spacing_mm;
  const Aabb box = image.lattice.bounds_mm();
  VoxelGrid grid;
  grid.voxel_mm = voxel_mm;
  grid.origin_mm = box.min + room;
  grid.dims = ((box.max - box.min - 2 * room) / voxel_mm).array().floor().cast<int>();
  return grid;
}

TEST(Resample, LinearRampIsExactWhetherVoxelsMergeOrDivide) {
  // 0.9 mm divides along z (1.4 mm) and merges along x and y (0.5, 0.6 mm); the others do one thing on all axes.
  const AlignedImage image = sampled({40, 36, 20}, {0.5, 0.6, 1.4}, ramp);
  for (const double voxel_mm : {0.23, 0.5, 0.9, 1.7}) {
    const VoxelGrid grid = grid_inside(image, voxel_mm);
    SliceResampler resampler(image, grid);
    for (int k = 0; k < grid.dims.z(); ++k) {
      const std::vector<double>& slice = resampler.slice(k);
      for (int j = 0; j < grid.dims.y(); ++j) {
        for (int i = 0; i < grid.dims.x(); ++i) {
          // A mean over a box of a function that is constant in each image voxel is not quite the ramp.
          const double bound = voxel_mm > 0.49 ? 15 : 1e-2;
          ASSERT_NEAR(slice[static_cast<std::size_t>(i + grid.dims.x() * j)], ramp(grid.center_mm({i, j, k})), bound)
              << voxel_mm;
        }
      }
    }
  }
}

TEST(Resample, MergingWholeVoxelsIsTheirMean) {
  const AlignedImage image = sampled({8, 8, 8}, Vec3::Ones(), [](const Vec3& p) {
    return 100 * std::sin(3 * p.x()) + 70 * std::cos(5 * p.y()) * p.z();
  });
  VoxelGrid grid{{4, 4, 4}, 2.0, image.lattice.bounds_mm().min};
  SliceResampler resampler(image, grid);
  for (int k = 0; k < 4; ++k) {
    const std::vector<double>& slice = resampler.slice(k);
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 4; ++i) {
        double mean = 0;
        for (int n = 0; n < 8; ++n) {
          mean += static_cast<double>(
                      image.value[image.lattice.index({2 * i + (n & 1), 2 * j + ((n >> 1) & 1), 2 * k + (n >> 2)})]) /
                  8;
        }
        EXPECT_NEAR(slice[static_cast<std::size_t>(i + 4 * j)], mean, 1e-4);
      }
    }
  }
}

TEST(Resample, AveragingKeepsTheSumAtAnyRatio) {
  const AlignedImage image =
      sampled({15, 15, 15}, Vec3::Ones(), [](const Vec3& p) { return std::sin(7 * p.sum()) * 100; });
  const double voxel_mm = 15.0 / 7;  // seven voxels for fifteen
  VoxelGrid grid{{7, 7, 7}, voxel_mm, image.lattice.bounds_mm().min};
  SliceResampler resampler(image, grid);
  double sum = 0;
  for (int k = 0; k < 7; ++k) {
    for (const double value : resampler.slice(k)) sum += value * grid.voxel_mm3();
  }
  double expected = 0;
  for (const float value : image.value) expected += static_cast<double>(value);
  EXPECT_NEAR(sum, expected, 1e-3);
}

TEST(Resample, DividingIsTrilinear) {
  const AlignedImage image =
      sampled({6, 6, 6}, Vec3::Ones(), [](const Vec3& p) { return p.x() * p.y() * p.z() + 3 * p.x() * p.y(); });
  // Trilinear interpolation reproduces a trilinear function.
  const VoxelGrid grid = grid_inside(image, 0.31);
  SliceResampler resampler(image, grid);
  for (int k = 0; k < grid.dims.z(); ++k) {
    const std::vector<double>& slice = resampler.slice(k);
    for (int j = 0; j < grid.dims.y(); ++j) {
      for (int i = 0; i < grid.dims.x(); ++i) {
        const Vec3 p = grid.center_mm({i, j, k});
        ASSERT_NEAR(slice[static_cast<std::size_t>(i + grid.dims.x() * j)], p.prod() + 3 * p.x() * p.y(), 1e-3);
      }
    }
  }
}

TEST(Resample, SameVoxelSizeIsTheImage) {
  const AlignedImage image =
      sampled({9, 8, 7}, Vec3::Constant(0.7), [](const Vec3& p) { return 50 * std::sin(9 * p.sum()); });
  VoxelGrid grid{{9, 8, 7}, 0.7, image.lattice.bounds_mm().min};
  SliceResampler resampler(image, grid);
  for (int k = 0; k < 7; ++k) {
    const std::vector<double>& slice = resampler.slice(k);
    for (std::size_t n = 0; n < slice.size(); ++n) {
      EXPECT_NEAR(slice[n], static_cast<double>(image.value[n + slice.size() * static_cast<std::size_t>(k)]), 1e-4);
    }
  }
}

/// A ball whose HU fall across the threshold of 200 over 3 mm, as a scanner's blur would have it.
double blurred_ball(const Vec3& p, double radius) {
  return std::clamp(200 + 200 * (radius - p.norm()), -100.0, 500.0);
}

struct Ball {
  double voxel_mm;
  Vec3 spacing_mm;
  double tolerance;  ///< of the volume, relative
};

class BallVolume : public ::testing::TestWithParam<Ball> {};

TEST_P(BallVolume, IsThatOfTheSphere) {
  constexpr double kRadius = 9;
  const Ball& ball = GetParam();
  const TempFolder folder;
  TestImage image;
  image.spacing_mm = ball.spacing_mm;
  image.dims = (Vec3::Constant(28).cwiseQuotient(ball.spacing_mm)).array().ceil().cast<int>();
  image.origin_mm = Vec3(-13.9, -13.6, -13.8);
  image.sample([](const Vec3& p) { return blurred_ball(p, kRadius); });
  write_image<float>(image, folder.file("ball.nrrd"));
  Diagnostics report;
  const FilledVoxmap voxmap = voxmap_from_ct(settings_for(folder.file("ball.nrrd"), ball.voxel_mm), report);
  const double expected = 4.0 / 3 * std::numbers::pi * std::pow(kRadius, 3);
  EXPECT_NEAR(volume_mm3(voxmap) / expected, 1, ball.tolerance);
  EXPECT_LT(centroid_mm(voxmap).norm(), 0.05);
}

INSTANTIATE_TEST_SUITE_P(Sizes, BallVolume,
                         ::testing::Values(Ball{0.3, {0.8, 0.8, 1.0}, 0.01}, Ball{0.5, {0.7, 0.7, 2.5}, 0.03},
                                           Ball{1.0, {1, 1, 1}, 0.01}, Ball{1.5, {0.5, 0.6, 0.7}, 0.02},
                                           Ball{0.9, {0.5, 0.5, 1.5}, 0.01}));

/// Greatest distance of a voxel on the surface from the sphere, in voxels of the voxmap.
double roughness_voxels(const Voxmap& voxmap, double radius) {
  double worst = 0;
  const Vec3i dims = voxmap.grid.dims;
  for (int k = 1; k < dims.z() - 1; ++k) {
    for (int j = 1; j < dims.y() - 1; ++j) {
      for (int i = 1; i < dims.x() - 1; ++i) {
        const double distance = voxmap.grid.center_mm({i, j, k}).norm() - radius;
        const bool bone = voxmap.grade.get({i, j, k}) != 0;
        if (bone == (distance > 0)) worst = std::max(worst, std::abs(distance) / voxmap.grid.voxel_mm);
      }
    }
  }
  return worst;
}

TEST(Surface, OfAThresholdIsSmootherThanTheImagesVoxels) {
  const TempFolder folder;
  TestImage image;
  image.dims = {28, 28, 28};
  image.origin_mm = Vec3(-13.9, -13.6, -13.8);
  image.sample([](const Vec3& p) { return blurred_ball(p, 9); });
  write_image<float>(image, folder.file("ball.nrrd"));
  Diagnostics report;
  const FilledVoxmap voxmap = voxmap_from_ct(settings_for(folder.file("ball.nrrd"), 0.2), report);
  // An image voxel is five voxels wide: nearest neighbours would be off by up to four (half its diagonal).
  EXPECT_LT(roughness_voxels(voxmap, 9), 0.25);
}

TEST(Surface, OfALabelMapIsSmootherThanTheImagesVoxels) {
  const TempFolder folder;
  TestImage image;
  image.dims = {28, 28, 28};
  image.origin_mm = Vec3(-13.9, -13.6, -13.8);
  image.sample([](const Vec3& p) { return p.norm() < 9 ? 3 : 0; });
  write_image<std::uint8_t>(image, folder.file("label.nrrd"));
  image.sample([](const Vec3&) { return 400; });
  write_image<std::int16_t>(image, folder.file("ct.nrrd"));
  BoneSettings settings = settings_for(folder.file("ct.nrrd"), 0.2);
  settings.ct.label_map = LabelMapSettings{.path = folder.file("label.nrrd"), .label = {"3"}};
  Diagnostics report;
  const FilledVoxmap voxmap = voxmap_from_ct(settings, report);
  EXPECT_LT(roughness_voxels(voxmap, 9), 2.6);
  // The Gaussian of 0.6 mm moves a surface of radius R inwards by about 0.6²/R, here 0.04 mm or 1.3 % of the volume.
  EXPECT_NEAR(volume_mm3(voxmap) / (4.0 / 3 * std::numbers::pi * 729), 1 - 0.013, 0.01);
}

TEST(Oblique, ImageComesOutWhereTheBoneIs) {
  const TempFolder folder;
  const Mat3 turned = (Eigen::AngleAxisd(0.35, Vec3::UnitZ()) * Eigen::AngleAxisd(-0.5, Vec3::UnitX()) *
                       Eigen::AngleAxisd(0.2, Vec3::UnitY()))
                          .toRotationMatrix();
  const Vec3 centre(40, -25, 310);
  // An ellipsoid along LPS axes, so that a wrong turn shows in its extent.
  const auto ellipsoid = [&](const Vec3& p) {
    return std::clamp(200 + 1000 * (1 - (p - centre).cwiseQuotient(Vec3(6, 9, 12)).norm()), -200.0, 600.0);
  };
  TestImage image;
  image.dims = {40, 44, 36};
  image.spacing_mm = {0.8, 0.8, 1.0};
  image.direction = turned;
  image.origin_mm = centre - turned * (0.5 * image.spacing_mm.cwiseProduct(image.dims.cast<double>()));
  image.sample(ellipsoid);
  for (const std::string name : {"oblique.nrrd", "oblique.nii", "oblique.mha"}) {
    write_image<float>(image, folder.file(name));
    Diagnostics report;
    const FilledVoxmap voxmap = voxmap_from_ct(settings_for(folder.file(name), 0.5), report);
    EXPECT_NEAR(volume_mm3(voxmap) / (4.0 / 3 * std::numbers::pi * 6 * 9 * 12), 1, 0.02) << name;
    EXPECT_LT((centroid_mm(voxmap) - centre).norm(), 0.1) << name;
    EXPECT_NE(grade_at(voxmap, centre + Vec3(0, 0, 11.3)), 0);
    EXPECT_NE(grade_at(voxmap, centre + Vec3(0, 8.3, 0)), 0);
    EXPECT_EQ(grade_at(voxmap, centre + Vec3(6.7, 0, 0)), 0);
    EXPECT_EQ(grade_at(voxmap, centre + Vec3(0, 9.7, 0)), 0);
  }
}

TEST(Oblique, CropHoldsInLpsAxes) {
  const TempFolder folder;
  const Mat3 turned = Eigen::AngleAxisd(0.6, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  TestImage image;
  image.dims = {40, 40, 40};
  image.direction = turned;
  image.origin_mm = turned * Vec3::Constant(-20);
  image.sample([](const Vec3& p) { return blurred_ball(p, 9); });
  write_image<float>(image, folder.file("ball.nrrd"));
  BoneSettings settings = settings_for(folder.file("ball.nrrd"), 0.5);
  settings.ct.crop_min_mm = Vec3(0, -15, -15);
  settings.ct.crop_max_mm = Vec3(15, 15, 15);
  Diagnostics report;
  const FilledVoxmap half = voxmap_from_ct(settings, report);
  EXPECT_NEAR(volume_mm3(half) / (2.0 / 3 * std::numbers::pi * 729), 1, 0.03);
  EXPECT_EQ(grade_at(half, Vec3(-0.6, 0, 0)), 0);
  EXPECT_NE(grade_at(half, Vec3(0.6, 0, 0)), 0);
}

TEST(Oblique, TiltedGantryIsAShearAndNoStretch) {
  // Slices of a DICOM series displaced along y from one to the next, as a tilted gantry leaves them.
  const TempFolder folder;
  TestImage image;
  image.dims = {30, 34, 30};
  image.direction.col(2) = Vec3(0, 0.25, 1);
  image.origin_mm = Vec3(-15, -20, -15);
  image.sample([](const Vec3& p) { return blurred_ball(p, 9); });
  write_dicom(image, folder.file("tilted"));
  Diagnostics report;
  const FilledVoxmap voxmap = voxmap_from_ct(settings_for(folder.file("tilted"), 0.5), report);
  EXPECT_NEAR(volume_mm3(voxmap) / (4.0 / 3 * std::numbers::pi * 729), 1, 0.03);
  EXPECT_LT(centroid_mm(voxmap).norm(), 0.2);
}

TEST(Density, GradeFollowsTheMappingOfTheScenario) {
  const TempFolder folder;
  TestImage image;
  image.dims = {20, 20, 20};
  image.sample([](const Vec3& p) { return (p - Vec3::Constant(9.5)).norm() < 7 ? 1000 : -50; });
  write_image<std::int16_t>(image, folder.file("a.nrrd"));
  BoneSettings settings = settings_for(folder.file("a.nrrd"), 1);
  Diagnostics report;
  const Vec3 centre = Vec3::Constant(9.5);
  // (0.0007·1000 − 0.009)/0.6 = 1.1517 g/cm³; in steps of 0.008: 144.
  EXPECT_EQ(grade_at(voxmap_from_ct(settings, report), centre), 144);
  settings.density = {0.0004, 0.1, 0.5};  // (0.4 + 0.1)/0.5 = 1
  const FilledVoxmap other = voxmap_from_ct(settings, report);
  EXPECT_EQ(grade_at(other, centre), 125);
  EXPECT_EQ(other.mapping.ash_slope_g_cm3_per_hu, 0.0004);
}

}  // namespace
}  // namespace reamsim::test
