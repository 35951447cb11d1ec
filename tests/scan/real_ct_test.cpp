// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "sim/scan/ct_import.h"
#include "sim/scenario/parse.h"
#include "test_images.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

/// The scenario that the project ships, at 0.8 mm to be quick.
BoneSettings shoulder() {
  return parse_scenario(REAMSIM_TRAJECTORIES "/ct_shoulder.yaml", {"bone.voxel_mm=0.8"}).bone;
}

class RealShoulder : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const std::string path = data_file("shoulder_ct/shoulder_left.nrrd");
    if (std::filesystem::exists(path)) voxmap_ = std::make_unique<FilledVoxmap>(voxmap_from_ct(shoulder(), report_));
  }
  static void TearDownTestSuite() { voxmap_.reset(); }
  void SetUp() override {
    if (!voxmap_) GTEST_SKIP() << "no " << data_file("shoulder_ct/shoulder_left.nrrd") << "; set REAMSIM_DATA";
  }

  static inline std::unique_ptr<FilledVoxmap> voxmap_;
  static inline Diagnostics report_;
  const Vec3 glenoid_{126.9, 175.9, -440.6};  // the data's README
  const Vec3 normal_ = Vec3(0.611, -0.548, 0.572).normalized();
  const Vec3 head_{139.2, 163.7, -427.7};
};

TEST_F(RealShoulder, FaceLiesWhereTheDataSaysItDoes) {
  // README: the face begins 1.3 to 1.8 mm behind the listed centre, which is good to 2 mm.
  double height = 10;
  while (height > -10 && grade_at(*voxmap_, glenoid_ + height * normal_) == 0) height -= 0.05;
  EXPECT_LT(height, -1.5 + 1.5);
  EXPECT_GT(height, -1.5 - 1.5);
  const Vec3 superior = Vec3(-0.54, 0.24, 0.81).normalized();
  const Vec3 across = superior.cross(normal_).normalized();
  // The face is concave and 32.6 by 24.5 mm: bone under all of it, air above it.
  for (const Vec3& p : {Vec3(glenoid_ + 12 * superior), Vec3(glenoid_ - 12 * superior), Vec3(glenoid_ + 8 * across),
                        Vec3(glenoid_ - 8 * across)}) {
    EXPECT_NE(grade_at(*voxmap_, p - 4 * normal_), 0) << p.transpose();
    EXPECT_EQ(grade_at(*voxmap_, p + 5 * normal_), 0) << p.transpose();
  }
}

TEST_F(RealShoulder, HumeralHeadIsAbsent) {
  std::int64_t inside = 0;
  double nearest = 1e9;
  for_each_bone_voxel(*voxmap_, [&](const Vec3i& c, std::uint8_t, std::uint16_t) {
    const double distance = (voxmap_->grid.center_mm(c) - head_).norm();
    inside += distance < 21.8;
    nearest = std::min(nearest, distance);
  });
  EXPECT_EQ(inside, 0);
  EXPECT_NEAR(nearest, 22.8, 0.8) << "the glenoid face is the nearest bone";
  EXPECT_EQ(grade_at(*voxmap_, head_ + 30 * (head_ - glenoid_).normalized()), 0) << "nor is the rest of the humerus";
}

TEST_F(RealShoulder, IsAWholeScapula) {
  EXPECT_GT(volume_mm3(*voxmap_), 50e3);
  EXPECT_LT(volume_mm3(*voxmap_), 75e3);
  const VoxelBox box = bone_extent(*voxmap_);
  const Vec3 extent = (box.last - box.first).cast<double>() * voxmap_->grid.voxel_mm;
  EXPECT_GT(extent.z(), 150) << "from the inferior angle to the acromion";
  EXPECT_NE(grade_at(*voxmap_, Vec3(134, 190, -407.5)), 0) << "acromion, cut off by the end of the scan";
  EXPECT_NE(grade_at(*voxmap_, Vec3(102.6, 151, -423.9)), 0) << "tip of the coracoid, the foremost point";
  EXPECT_NE(grade_at(*voxmap_, Vec3(109, 198.6, -565)), 0) << "inferior angle";
  // Ribs, clavicle and humerus are other pieces.
  EXPECT_THAT(report_.notes[5], HasSubstr("kept the one with the seed"));
}

TEST_F(RealShoulder, TheReamersWayToTheFaceIsFree) {
  // Along the normal, in the 30 mm wide path of the reamer: nothing but the glenoid itself, whose rim rises 2.5 mm.
  for_each_bone_voxel(*voxmap_, [&](const Vec3i& c, std::uint8_t, std::uint16_t) {
    const Vec3 from = voxmap_->grid.center_mm(c) - glenoid_;
    const double height = from.dot(normal_);
    if (height < 3) return;
    ASSERT_GT((from - height * normal_).norm(), 25) << height;
  });
}

TEST_F(RealShoulder, TrabecularInsideOfTheVaultIsKept) {
  // Straight down the vault from the face: bone all the way, dense first, then trabecular.
  double plate = 0;
  double deep = 1e9;
  for (double depth = 2.5; depth < 18; depth += 0.4) {
    const std::uint8_t grade = grade_at(*voxmap_, glenoid_ - depth * normal_);
    EXPECT_NE(grade, 0) << depth;
    const double hu = voxmap_->mapping.hu_from_density(DensityMapping::density_from_grade(grade));
    if (depth < 5) plate = std::max(plate, hu);
    if (depth > 6 && depth < 15) deep = std::min(deep, hu);
  }
  EXPECT_GT(plate, 650);
  EXPECT_LT(deep, 400);
  // Some of the kept bone is below the threshold that found it.
  double share = -1;
  for (const std::string& note : report_.notes) {
    const std::size_t at = note.find("bone voxels (");
    if (at != std::string::npos) share = std::stod(note.substr(at + 13));
  }
  EXPECT_GT(share, 1.5);
  EXPECT_LT(share, 15);
}

TEST(RealBody, Int32NiftiInRasIsReadWithTheRightAxes) {
  const std::string path = data_file("body_ct/body_3mm_int32.nii.gz");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path << "; set REAMSIM_DATA";
  Diagnostics report;
  BoneSettings settings = settings_for(path, 3);
  settings.ct.closing_mm = 0;
  const FilledVoxmap spine = voxmap_from_ct(settings, report);
  EXPECT_THAT(report.notes.front(), HasSubstr("NIfTI, int32, sform (code 2, coordinates aligned to another scan), "
                                              "122x101x112 voxels of 3x3x3 mm, axes along LPS"));
  // 122 × 3 mm wide, 101 × 3 mm deep, 112 × 3 mm high, whatever the order and sense of the axes in the file.
  const std::string& note = report.notes.front();
  double low[3];
  double high[3];
  const std::string box = note.substr(note.find("LPS, (") + 5);
  ASSERT_EQ(
      std::sscanf(box.c_str(), "(%lf, %lf, %lf) to (%lf, %lf, %lf)", low, low + 1, low + 2, high, high + 1, high + 2),
      6);
  EXPECT_NEAR(high[0] - low[0], 366, 0.2);
  EXPECT_NEAR(high[1] - low[1], 303, 0.2);
  EXPECT_NEAR(high[2] - low[2], 336, 0.2);
  // The largest bone is the spine, and a spine lies behind (+y) the middle of the body.
  EXPECT_GT(centroid_mm(spine).y(), 0.5 * (low[1] + high[1]));
}

/// The same bone with headers of other programs; the README of the data has its volume.
TEST(OddScans, HaveTheBoneOfTheReference) {
  constexpr double kTruth_mm3 = 7658;
  const std::pair<const char*, bool> files[]{
      {"sform.nii.gz", false},       {"pixdim_sform_q.nii.gz", true}, {"conflict_s2q1.nii.gz", true},
      {"shear_both.nii.gz", true},   {"shear_s_only.nii.gz", true},   {"oblique_round.nii.gz", true},
      {"u16_off1024.nii.gz", false}, {"gzip_named_nii.nii", false},   {"dicom_plain", false},
      {"dicom_z625r1", true},        {"dicom_missing_end", true}};
  for (const auto& [name, warned] : files) {
    SCOPED_TRACE(name);
    BoneSettings settings;
    settings.source = BoneSource::ct;
    settings.voxel_mm = 0.25;
    settings.surface_voxels = SurfaceVoxels::partial;
    settings.ct.path = data_file(std::string("odd_files/") + name);
    if (!std::filesystem::exists(settings.ct.path)) GTEST_SKIP() << "no " << settings.ct.path << "; set REAMSIM_DATA";
    if (std::string(name).starts_with("u16")) settings.ct.hu = HuSettings{.slope = 1, .intercept = -1024};
    Diagnostics report;
    const FilledVoxmap voxmap = voxmap_from_ct(settings, report);
    EXPECT_NEAR(voxmap.bone_mm3(), kTruth_mm3, 0.01 * kTruth_mm3);
    EXPECT_EQ(!report.warnings.empty(), warned);
    if (std::string(name).starts_with("oblique")) continue;  // the header turns the bone
    for (const Vec3& seed : {Vec3(26, -20, 30), Vec3(10, -20, 47), Vec3(10, -35, 30)})
      EXPECT_NE(grade_at(voxmap, seed), 0) << seed.transpose();
  }
}

}  // namespace
}  // namespace reamsim::test
