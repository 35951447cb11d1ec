// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/base/error.h"
#include "sim/scan/ct_import.h"
#include "sim/scan/segment.h"
#include "test_images.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// Two balls along x, 9 mm and 7 mm in radius, dense (600) outside and trabecular (80, below the threshold) inside,
/// with `gap` mm between them; the larger one is round the origin.
std::function<double(const Vec3&)> two_bones(double gap) {
  return [gap](const Vec3& p) {
    const double large = p.norm();
    const double small = (p - Vec3(16 + gap, 0, 0)).norm();
    if (large < 6.5 || small < 4.5) return 80.0;
    return large < 9 || small < 7 ? 600.0 : 0.0;
  };
}

class Segmentation : public ::testing::Test {
 protected:
  BoneSettings write(const std::function<double(const Vec3&)>& function, double voxel_mm = 0.5) {
    image_.dims = {76, 46, 46};
    image_.spacing_mm = Vec3::Constant(0.5);
    image_.origin_mm = Vec3(-11.25, -11.25, -11.25);
    image_.sample(function);
    write_image<std::int16_t>(image_, folder_.file("ct.nrrd"));
    return settings_for(folder_.file("ct.nrrd"), voxel_mm);
  }
  FilledVoxmap import(const BoneSettings& settings) { return voxmap_from_ct(settings, report_); }
  std::string notes() const {
    std::string all;
    for (const std::string& note : report_.notes) all += note + "\n";
    return all;
  }

  TempFolder folder_;
  TestImage image_;
  Diagnostics report_;
  static double ball(double radius) { return 4.0 / 3 * std::numbers::pi * std::pow(radius, 3); }
};

TEST_F(Segmentation, TrabecularInsideStaysBone) {
  const FilledVoxmap voxmap = import(write(two_bones(2)));
  EXPECT_NEAR(volume_mm3(voxmap) / ball(9), 1, 0.03);
  // (0.0007·80 − 0.009)/0.6 = 0.0783 g/cm³, grade 10: kept, and kept as light as it is.
  EXPECT_EQ(grade_at(voxmap, Vec3(0.1, 0.1, 0.1)), 10);
  EXPECT_THAT(notes(), HasSubstr("are below 200 HU"));
}

TEST_F(Segmentation, ACutThatBoneEnclosesIsNotFilled) {
  BoneSettings settings = write([](const Vec3& p) { return p.norm() < 9 ? 600.0 : 0.0; });
  settings.ct.cut_spheres = {{Vec3::Zero(), 4}};
  settings.ct.fill_holes = true;
  reamsim::Segmentation facts;
  const FilledVoxmap voxmap = voxmap_from_ct(settings, report_, &facts);
  EXPECT_EQ(grade_at(voxmap, Vec3(0.1, 0.1, 0.1)), 0);
  EXPECT_NEAR(facts.filled_mm3, 0, 1e-9);
  EXPECT_NEAR(facts.bone_mm3 / (ball(9) - ball(4)), 1, 0.02);
  EXPECT_THAT(notes(), HasSubstr("filled (0 voxels)"));
}

TEST_F(Segmentation, BoneDenserThanAGradeHoldsIsWarnedOf) {
  const auto warnings_with = [this](double hu) {
    report_ = {};
    import(write([hu](const Vec3& p) { return p.norm() > 9 ? -1000 : p.norm() < 4 ? hu : 600.0; }));
  return testing::PrintToString(report_.warnings);
};
EXPECT_EQ(warnings_with(1700), "{}");
EXPECT_THAT(warnings_with(2200), AllOf(HasSubstr("of the bone is denser than 2 g/cm3 (1727 HU)"),
                                       HasSubstr("forces there are too small"), Not(HasSubstr("metal"))));
EXPECT_THAT(warnings_with(3071), AllOf(HasSubstr("denser than 2 g/cm3"), HasSubstr("above 3000 HU: is it metal?")));
}

TEST_F(Segmentation, WithoutFillingTheInsideIsAir) {
  BoneSettings settings = write(two_bones(2));
  settings.ct.fill_holes = false;
  const FilledVoxmap voxmap = import(settings);
  EXPECT_EQ(grade_at(voxmap, Vec3(0.1, 0.1, 0.1)), 0);
  EXPECT_NEAR(volume_mm3(voxmap) / (ball(9) - ball(6.5)), 1, 0.06);
}

TEST_F(Segmentation, LargestPieceWithoutASeed) {
  const FilledVoxmap voxmap = import(write(two_bones(2)));
  EXPECT_LT(centroid_mm(voxmap).norm(), 0.1);
  EXPECT_EQ(grade_at(voxmap, Vec3(24, 0, 0)), 0);
  EXPECT_THAT(notes(), HasSubstr("2 connected pieces; kept the largest"));
}

TEST_F(Segmentation, SeedChoosesThePieceFromItsShellOrItsTrabecularInside) {
  BoneSettings settings = write(two_bones(2));
  for (const Vec3& seed : {Vec3(18, 0, 0), Vec3(18, 0, 5.75)}) {  // inside, below the threshold; in the shell
    settings.ct.seed_mm = seed;
    const FilledVoxmap voxmap = import(settings);
    EXPECT_NEAR(volume_mm3(voxmap) / ball(7), 1, 0.04);
    EXPECT_LT((centroid_mm(voxmap) - Vec3(18, 0, 0)).norm(), 0.1);
  }
  EXPECT_THAT(notes(), HasSubstr("kept the one with the seed"));
}

TEST_F(Segmentation, ClosingSealsALeakInTheShellSoThatTheInsideStays) {
  const auto leaky = [](const Vec3& p) {
    const bool hole = p.x() < 0 && std::abs(p.y()) < 0.6 && std::abs(p.z()) < 0.6;
    return p.norm() < 9 && !(p.norm() < 6.5) && !hole ? 600.0 : (p.norm() < 6.5 ? 80.0 : 0.0);
  };
  BoneSettings settings = write(leaky);
  EXPECT_EQ(grade_at(import(settings), Vec3(0.1, 0.1, 0.1)), 0) << "the hole must leak, or this tests nothing";
  settings.ct.closing_mm = 1.5;
  const FilledVoxmap voxmap = import(settings);
  EXPECT_EQ(grade_at(voxmap, Vec3(0.1, 0.1, 0.1)), 10);
  EXPECT_NEAR(volume_mm3(voxmap) / ball(9), 1, 0.04);
}

TEST_F(Segmentation, ClosingDoesNotBridgeAJoint) {
  BoneSettings settings = write(two_bones(1.5));  // narrower than the closing ball
  settings.ct.closing_mm = 2;
  const FilledVoxmap voxmap = import(settings);
  EXPECT_NEAR(volume_mm3(voxmap) / ball(9), 1, 0.04);
  EXPECT_EQ(grade_at(voxmap, Vec3(9.75, 0, 0)), 0) << "the gap stays a gap";
}

TEST_F(Segmentation, CutSpherePartsBonesThatTouch) {
  BoneSettings settings = write(two_bones(-1));
  EXPECT_GT(volume_mm3(import(settings)), 0.97 * (ball(9) + ball(7)) - 30);
  settings.ct.cut_spheres.push_back({Vec3(15, 0, 0), 7});
  const FilledVoxmap voxmap = import(settings);
  EXPECT_EQ(grade_at(voxmap, Vec3(15, 0, 0)), 0);
  EXPECT_EQ(grade_at(voxmap, Vec3(8.5, 0, 0)), 0) << "in the sphere";
  EXPECT_NE(grade_at(voxmap, Vec3(7.5, 0, 0)), 0) << "outside it";
  EXPECT_GT(volume_mm3(voxmap), 0.95 * ball(9));
  EXPECT_LT(volume_mm3(voxmap), ball(9));
  EXPECT_THAT(notes(), HasSubstr("cuts removed"));
}

TEST_F(Segmentation, WhatWasDoneIsThereAsData) {
  BoneSettings settings = write(two_bones(2));
  reamsim::Segmentation done;
  voxmap_from_ct(settings, report_, &done);
  EXPECT_EQ(done.method, "threshold");
  EXPECT_EQ(done.pieces, 2);
  EXPECT_FALSE(done.by_seed);
  EXPECT_EQ(done.kept_rank, 1);
  EXPECT_NEAR(done.bone_mm3 / ball(9), 1, 0.03);
  EXPECT_NEAR(done.filled_mm3 / ball(6.5), 1, 0.05) << "the trabecular inside";
  EXPECT_NEAR(done.below_threshold_fraction, ball(6.5) / ball(9), 0.02);
  EXPECT_NEAR(done.kept_piece_mm3 + done.closed_mm3 + done.filled_mm3, done.bone_mm3, 1e-6);
  EXPECT_NEAR(done.second_mm3 / (ball(7) - ball(4.5)), 1, 0.05);
  EXPECT_NEAR(done.dropped_mm3, done.second_mm3, 1e-6);
  EXPECT_EQ(done.cut_mm3, 0);

  settings.ct.seed_mm = Vec3(18, 0, 0);
  settings.ct.cut_spheres.push_back({Vec3(18, 0, 7), 2});
  voxmap_from_ct(settings, report_, &done);
  EXPECT_TRUE(done.by_seed);
  EXPECT_EQ(done.kept_rank, 2);
  EXPECT_GT(done.cut_mm3, 10);
  EXPECT_NEAR(done.dropped_mm3, done.largest_mm3, 1e-6);
}

TEST_F(Segmentation, WithoutASeedASecondLargePieceIsWarnedOf) {
  BoneSettings settings = write(two_bones(2));
  import(settings);
  ASSERT_EQ(report_.warnings.size(), 1U);
  EXPECT_THAT(report_.warnings[0], AllOf(HasSubstr("bone.ct.seed_mm"), HasSubstr("The second largest has ")));
  settings.ct.seed_mm = Vec3(0, 0, 0);
  report_ = {};
  import(settings);
  EXPECT_TRUE(report_.warnings.empty());
}

TEST_F(Segmentation, PlanesGoThroughTheSeedAsARadiologistLooks) {
  BoneSettings settings = write(two_bones(2));
  settings.ct.seed_mm = Vec3(0.25, 1.25, -2.25);  // a voxel's centre: (23, 25, 18)
  reamsim::Segmentation done;
  voxmap_from_ct(settings, report_, &done);
  ASSERT_EQ(done.planes.size(), 3U);
  const auto expect = [&](const ScanPlane& plane, const char* name, int columns, int rows, const Vec2& through) {
    EXPECT_EQ(plane.name, name);
    EXPECT_EQ(plane.columns, columns);
    EXPECT_EQ(plane.rows, rows);
    EXPECT_EQ(plane.through, through) << name;
    const std::size_t at = plane.at(static_cast<int>(through.x()), static_cast<int>(through.y()));
    EXPECT_EQ(plane.hu[at], 80) << name;
    EXPECT_GT(plane.field[at], 0) << name;
    EXPECT_LT(plane.field[plane.at(columns - 1, 0)], 0) << name << ": air, or the other bone";
  };
  expect(done.planes[0], "axial", 76, 46, {23, 25});
  expect(done.planes[1], "coronal", 76, 46, {23, 45 - 18});
  expect(done.planes[2], "sagittal", 46, 46, {25, 45 - 18});
  EXPECT_EQ(done.planes[0].left, "R") << "the patient's right is on the left";
  EXPECT_EQ(done.planes[1].top, "S");
}

TEST_F(Segmentation, CutPlaneRemovesTheSideOfItsNormalAndIsFlat) {
  const auto solid = [](const Vec3& p) { return p.norm() < 9 ? 400.0 : 0.0; };  // 200 HU lies halfway
  BoneSettings settings = write(solid, 0.2);
  const Vec3 normal = Vec3(1, 0.4, -0.3).normalized();
  settings.ct.cut_planes.push_back({Vec3(2, 0, 0), normal});
  const FilledVoxmap voxmap = import(settings);
  const double height = 9 - normal.dot(Vec3(2, 0, 0));  // of the cap that goes
  const double cap = std::numbers::pi * height * height * (9 - height / 3);
  EXPECT_NEAR(volume_mm3(voxmap) / (ball(9) - cap), 1, 0.02);
  // Flat to a voxel of the voxmap (0.2 mm) although the image's voxels are 0.5 mm.
  for (int n = 0; n < 40; ++n) {
    const double angle = 0.3 * n;
    const Vec3 u = normal.unitOrthogonal();
    const Vec3 on_plane = Vec3(2, 0, 0) + (n % 5) * (std::cos(angle) * u + std::sin(angle) * normal.cross(u));
    EXPECT_NE(grade_at(voxmap, on_plane - 0.2 * normal), 0);
    EXPECT_EQ(grade_at(voxmap, on_plane + 0.2 * normal), 0);
  }
}

TEST_F(Segmentation, BoneThatLeavesTheCropKeepsItsInside) {
  // A tube along x, filled with marrow, cut off by both ends of the image.
  BoneSettings settings = write([](const Vec3& p) {
    const double r = Vec2(p.y(), p.z()).norm();
    return r < 5 ? 50.0 : (r < 8 ? 700.0 : -100.0);
  });
  const FilledVoxmap voxmap = import(settings);
  EXPECT_NE(grade_at(voxmap, Vec3(0, 0, 0)), 0);
  EXPECT_NE(grade_at(voxmap, Vec3(-11, 0, 0)), 0) << "up to the end of the image";
  EXPECT_NEAR(volume_mm3(voxmap) / (std::numbers::pi * 64 * 38), 1, 0.03);
}

TEST_F(Segmentation, LabelMapReplacesThresholdSeedAndCuts) {
  BoneSettings settings = write(two_bones(2));
  TestImage labels = image_;
  labels.sample([](const Vec3& p) { return p.norm() < 9 ? 2 : ((p - Vec3(18, 0, 0)).norm() < 7 ? 5 : 0); });
  write_image<std::uint8_t>(labels, folder_.file("labels.nii.gz"));
  settings.ct.label_map = LabelMapSettings{.path = folder_.file("labels.nii.gz"), .label = {"5"}};
  settings.ct.threshold_hu = 5000;  // none of these counts now
  settings.ct.cut_spheres.push_back({Vec3(18, 0, 0), 20});
  settings.ct.seed_mm = Vec3(0, 0, 0);
  const FilledVoxmap voxmap = import(settings);
  EXPECT_NEAR(volume_mm3(voxmap) / ball(7), 1, 0.03);
  EXPECT_LT((centroid_mm(voxmap) - Vec3(18, 0, 0)).norm(), 0.1);
  EXPECT_EQ(grade_at(voxmap, Vec3(18, 0, 0)), 10) << "HU come from the image";
}

TEST_F(Segmentation, LabelMapOfAnObliqueImage) {
  TestImage image;
  const Mat3 turned = Eigen::AngleAxisd(0.4, Vec3(2, -1, 1).normalized()).toRotationMatrix();
  image.dims = {30, 30, 30};
  image.direction = turned;
  image.origin_mm = turned * Vec3::Constant(-14.5);
  image.sample([](const Vec3&) { return 500; });
  write_image<std::int16_t>(image, folder_.file("ct.nii"));
  image.sample([](const Vec3& p) { return p.norm() < 8 ? 4 : 0; });
  write_image<std::int16_t>(image, folder_.file("labels.nrrd"));
  BoneSettings settings = settings_for(folder_.file("ct.nii"), 0.5);
  settings.ct.label_map = LabelMapSettings{.path = folder_.file("labels.nrrd"), .label = {"4"}};
  const FilledVoxmap voxmap = import(settings);
  EXPECT_NEAR(volume_mm3(voxmap) / ball(8), 1, 0.03);
  EXPECT_LT(centroid_mm(voxmap).norm(), 0.1);
}

double spread(const Voxmap& voxmap, double radius) {
  double sum = 0, squares = 0;
  int count = 0;
  for (std::int64_t n = 0; n < voxmap.grid.size(); ++n) {
    const Vec3i c = voxmap.grid.coord(n);
    if (voxmap.grid.center_mm(c).norm() > radius) continue;
    const double grade = voxmap.grade.get(c);
    sum += grade;
    squares += grade * grade;
    ++count;
  }
  return std::sqrt(squares / count - std::pow(sum / count, 2));
}

TEST_F(Segmentation, FiltersTakeTheNoiseOutAndLeaveTheEdge) {
  constexpr unsigned kSeed = 20240611;
  unsigned state = kSeed;
  BoneSettings settings = write([&](const Vec3& p) {
    state = state * 1664525U + 1013904223U;
    const double noise = (static_cast<double>(state >> 8) / (1 << 24) - 0.5) * 200;
    return (p.norm() < 9 ? 600.0 : -100.0) + noise;
  });
  const double raw = spread(import(settings), 6);
  ASSERT_GT(raw, 5) << "seed " << kSeed;
  for (const CtFilter filter : {CtFilter::median, CtFilter::curvature_anisotropic}) {
    settings.ct.filter = filter;
    const FilledVoxmap voxmap = import(settings);
    EXPECT_LT(spread(voxmap, 6), 0.6 * raw) << name_of(filter);
    EXPECT_NEAR(volume_mm3(voxmap) / ball(9), 1, 0.03) << name_of(filter);
    EXPECT_THAT(notes(), HasSubstr(filter == CtFilter::median ? "median filter, radius 1" : "curvature anisotropic"));
  }
}

TEST_F(Segmentation, NotANumberIsReplacedAndWarnedOf) {
  TestImage image = egg_image();
  image.value[0] = std::nan("");
  image.value[5] = INFINITY;
  write_image<float>(image, folder_.file("nan.nrrd"));
  EXPECT_GT(volume_mm3(import(settings_for(folder_.file("nan.nrrd"), 1))), 3000);
  ASSERT_EQ(report_.warnings.size(), 1U);
  EXPECT_THAT(report_.warnings[0], HasSubstr("2 voxels are NaN or infinite"));
}

TEST(FillHoles, PocketInsideIsFilledAndNotchIsNot) {
  const ct::Lattice lattice{{7, 7, 7}, Vec3::Ones(), Vec3::Zero()};
  ct::Mask mask(343, 0);
  for (int k = 1; k < 6; ++k) {
    for (int j = 1; j < 6; ++j) {
      for (int i = 1; i < 6; ++i) mask[lattice.index({i, j, k})] = 1;
    }
  }
  mask[lattice.index({3, 3, 3})] = 0;  // a pocket
  mask[lattice.index({1, 2, 2})] = 0;  // a notch
  EXPECT_EQ(ct::fill_holes(mask, lattice), 1);
  EXPECT_EQ(mask[lattice.index({3, 3, 3})], 1);
  EXPECT_EQ(mask[lattice.index({1, 2, 2})], 0);
}

TEST(ConnectedPieces, CountsFacesNotCornersLargestFirst) {
  const ct::Lattice lattice{{6, 3, 3}, Vec3::Ones(), Vec3::Zero()};
  ct::Mask mask(54, 0);
  mask[lattice.index({0, 0, 0})] = 1;
  mask[lattice.index({1, 1, 0})] = 1;  // touches the first along an edge only
  mask[lattice.index({2, 1, 0})] = 1;
  const ct::Pieces pieces = ct::connected_pieces(mask, lattice);
  ASSERT_EQ(pieces.list.size(), 2U);
  EXPECT_EQ(pieces.list[0].voxels, 2);
  EXPECT_EQ(pieces.list[0].min, Vec3i(1, 1, 0));
  EXPECT_EQ(pieces.list[0].max, Vec3i(2, 1, 0));
  EXPECT_EQ(pieces.label[lattice.index({0, 0, 0})], 2U);
}

TEST_F(Segmentation, AScanToLookAtHasTheSameBoneAsTheVoxmap) {
  BoneSettings settings = write(two_bones(-1));
  settings.ct.cut_spheres.push_back({Vec3(15, 0, 0), 7});
  const FilledVoxmap voxmap = import(settings);
  const SegmentedScan scan = segmented_scan(settings, report_);
  ASSERT_EQ(scan.field.size(), scan.hu.value.size());
  double bone_mm3 = 0;
  scan.hu.lattice.for_each([&](const Vec3i& voxel, std::size_t at) {
    if (scan.field[at] <= 0) return;
    bone_mm3 += scan.hu.lattice.voxel_mm3();
    EXPECT_GE((scan.hu.lattice.center_mm(voxel) - Vec3(15, 0, 0)).norm(), 7) << "cut away";
  });
  EXPECT_NEAR(bone_mm3 / volume_mm3(voxmap), 1, 0.03);
}

TEST_F(Segmentation, AScanToLookAtSurvivesASeedOutsideTheBone) {
  BoneSettings settings = write(two_bones(2));
  settings.ct.seed_mm = Vec3(-11, -11, -11);
  const SegmentedScan scan = segmented_scan(settings, report_);
  EXPECT_TRUE(scan.field.empty());
  EXPECT_FALSE(scan.hu.value.empty());
  ASSERT_EQ(scan.mistakes.size(), 1U);
  EXPECT_EQ(scan.mistakes[0].key, "bone.ct.seed_mm");
}

}  // namespace
}  // namespace reamsim::test
