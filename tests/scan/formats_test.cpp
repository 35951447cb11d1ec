// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

#include "sim/scan/ct_import.h"
#include "test_images.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

FilledVoxmap import(const std::string& path, double voxel_mm = 1) {
  Diagnostics report;
  return voxmap_from_ct(settings_for(path, voxel_mm), report);
}

class Formats : public ::testing::Test {
 protected:
  void SetUp() override {
    write_image<std::int16_t>(egg_, folder_.file("reference.nrrd"));
    reference_ = import(folder_.file("reference.nrrd"));
    ASSERT_GT(volume_mm3(reference_), 3000);
  }

  TempFolder folder_;
  TestImage egg_ = egg_image();
  FilledVoxmap reference_;
};

TEST_F(Formats, EveryFileFormatGivesTheSameVoxmap) {
  for (const char* name : {"a.nrrd", "a.nhdr", "a.nii", "a.nii.gz", "a.mha", "a.mhd"}) {
    for (const bool compressed : {false, true}) {
      const std::string path = folder_.file((compressed ? "packed_" : "plain_") + std::string(name));
      write_image<std::int16_t>(egg_, path, compressed);
      expect_same(import(path), reference_, path);
    }
  }
}

TEST_F(Formats, DicomSeriesIsSortedByPositionNotByName) {
  write_dicom(egg_, folder_.file("series"));
  expect_same(import(folder_.file("series")), reference_, "DICOM");
}

/// Gives a stored DICOM file, implicit VR, another value of a tag in group 0028: two characters for two.
void patch_tag(const std::string& path, int element, const std::string& from, const std::string& to) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const std::string tag{0x28, 0x00, static_cast<char>(element & 255), static_cast<char>(element >> 8), 2, 0, 0, 0};
  const std::size_t at = bytes.find(tag + from);
  ASSERT_NE(at, std::string::npos) << path;
  bytes.replace(at + tag.size(), 2, to);
  std::ofstream(path, std::ios::binary) << bytes;
}

TEST_F(Formats, DicomRescaleCountsInHu) {
  write_dicom(egg_, folder_.file("series"));
  for (const auto& slice : std::filesystem::directory_iterator(folder_.file("series"))) {
    patch_tag(slice.path().string(), 0x1052, "0 ", "64");  // intercept
    patch_tag(slice.path().string(), 0x1053, "1 ", "2 ");  // slope
  }
  Diagnostics report;
  BoneSettings settings = settings_for(folder_.file("series"), 1);
  settings.ct.threshold_hu = 2 * 200 + 64;
  const FilledVoxmap voxmap = voxmap_from_ct(settings, report);
  EXPECT_NEAR(volume_mm3(voxmap), volume_mm3(reference_), 1e-6);
  EXPECT_THAT(report.notes.back(), HasSubstr("HU 264 to 564"));
}

TEST_F(Formats, DicomFolderMayHoldOtherFilesAndAScout) {
  write_dicom(egg_, folder_.file("series"));
  std::ofstream(folder_.file("series/notes.txt")) << "not DICOM";
  TestImage scout = egg_;
  scout.dims = {40, 12, 1};
  scout.sample(knobbed_egg);
  write_dicom(scout, folder_.file("scout"));
  std::filesystem::copy(folder_.file("scout/slice001.dcm"), folder_.file("series/a_scout.dcm"));
  Diagnostics report;
  expect_same(voxmap_from_ct(settings_for(folder_.file("series"), 1), report), reference_, "with a scout");
  ASSERT_EQ(report.warnings.size(), 1U);
  EXPECT_THAT(report.warnings[0], HasSubstr("images of the DICOM series skipped: 1, the first is "));
  EXPECT_THAT(report.warnings[0], HasSubstr("a_scout.dcm and has 40x12 pixels; the other slices have 26x30"));
}

TEST_F(Formats, DicomIsReadOnlyWhereTheCropIs) {
  write_dicom(egg_, folder_.file("series"));
  Diagnostics report;
  BoneSettings settings = settings_for(folder_.file("series"), 1);
  settings.ct.crop_max_mm = Vec3(0, 100, 110);
  const FilledVoxmap cropped = voxmap_from_ct(settings, report);
  settings.ct.path = folder_.file("reference.nrrd");
  expect_same(cropped, voxmap_from_ct(settings, report), "crop of DICOM");
  EXPECT_LT(volume_mm3(cropped), 0.7 * volume_mm3(reference_));
}

template <typename Value>
void expect_type(const TempFolder& folder, const TestImage& image, const Voxmap& reference, const std::string& name) {
  for (const std::string ending : {".nrrd", ".mha", ".nii"}) {
    const std::string path = folder.file(name + ending);
    write_image<Value>(image, path);
    expect_same(import(path), reference, path);
  }
}

TEST_F(Formats, EveryPixelTypeGivesTheSameVoxmap) {
  expect_type<std::uint8_t>(folder_, egg_, reference_, "uint8");
  expect_type<std::uint16_t>(folder_, egg_, reference_, "uint16");
  expect_type<std::int32_t>(folder_, egg_, reference_, "int32");
  expect_type<std::uint32_t>(folder_, egg_, reference_, "uint32");
  expect_type<float>(folder_, egg_, reference_, "float");
  expect_type<double>(folder_, egg_, reference_, "double");
}

TEST_F(Formats, SignedBytesKeepTheirSign) {
  TestImage image = egg_;
  for (double& value : image.value) value -= 128;
  write_image<std::int8_t>(image, folder_.file("int8.nrrd"));
  BoneSettings settings = settings_for(folder_.file("int8.nrrd"), 1);
  settings.ct.threshold_hu = 200 - 128;
  Diagnostics report;
  EXPECT_NEAR(volume_mm3(voxmap_from_ct(settings, report)), volume_mm3(reference_), 1e-6);
}

TEST_F(Formats, ValuesWithAnOffsetAreWarnedOfAndReadByAKey) {
  TestImage in_air = egg_, offset = egg_;
  for (double& value : in_air.value) value = value == 0 ? -1000 : value;
  std::ranges::transform(in_air.value, offset.value.begin(), [](double hu) { return hu + 1024; });
  write_image<std::int16_t>(in_air, folder_.file("hu.nrrd"));
  write_image<std::uint16_t>(offset, folder_.file("offset.nrrd"));
  BoneSettings settings = settings_for(folder_.file("offset.nrrd"), 1);
  Diagnostics report;
  voxmap_from_ct(settings, report);
  ASSERT_FALSE(report.warnings.empty());
  EXPECT_THAT(report.warnings.front(), HasSubstr("set bone.ct.hu.intercept to -1024"));
  // Without air there is no offset to propose.
  BoneSettings inside = settings;
  inside.ct.crop_min_mm = Vec3(-23, 32, 107);
  inside.ct.crop_max_mm = Vec3(-17, 38, 113);
  report = {};
  voxmap_from_ct(inside, report);
  EXPECT_THAT(report.warnings, ::testing::Contains(HasSubstr("If the values are offset, set bone.ct.hu.intercept")));
  settings.ct.hu = {.slope = 1, .intercept = -1024};
  report = {};
  expect_same(voxmap_from_ct(settings, report), import(folder_.file("hu.nrrd")), "by the key");
  EXPECT_TRUE(report.warnings.empty());
}

TEST_F(Formats, EveryOrderAndSenseOfTheAxesGivesTheSameVoxmap) {
  std::array<int, 3> axes{0, 1, 2};
  int cases = 0;
  do {
    for (int bits = 0; bits < 8; ++bits) {
      const std::array<bool, 3> flip{(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
      const std::string name = std::to_string(axes[0]) + std::to_string(axes[1]) + std::to_string(axes[2]) + "_" +
                               std::to_string(bits) + (cases % 2 == 0 ? ".nrrd" : ".mha");
      write_image<std::int16_t>(reordered(egg_, axes, flip), folder_.file(name));
      expect_same(import(folder_.file(name)), reference_, name);
      ++cases;
    }
  } while (std::next_permutation(axes.begin(), axes.end()));
  EXPECT_EQ(cases, 48);
}

TEST_F(Formats, RasAndLasNiftiGiveTheSameVoxmap) {
  // Both x and y reversed is what NIfTI calls RAS; x alone is the other handedness.
  write_image<std::int16_t>(reordered(egg_, {0, 1, 2}, {true, true, false}), folder_.file("ras.nii.gz"));
  write_image<std::int16_t>(reordered(egg_, {1, 2, 0}, {true, false, false}), folder_.file("odd.nii.gz"));
  expect_same(import(folder_.file("ras.nii.gz")), reference_, "RAS");
  expect_same(import(folder_.file("odd.nii.gz")), reference_, "permuted, reversed");
}

TEST_F(Formats, ReportSaysWhatWasDone) {
  Diagnostics report;
  voxmap_from_ct(settings_for(folder_.file("reference.nrrd"), 0.5), report);
  std::string all;
  for (const std::string& note : report.notes) all += note + "\n";
  EXPECT_THAT(all, HasSubstr("NRRD, int16, space left-posterior-superior, 26x30x24 voxels of 1x1x1.25 mm"));
  EXPECT_THAT(all, HasSubstr("threshold 200 HU"));
  EXPECT_THAT(all, HasSubstr("1 connected pieces"));
  EXPECT_THAT(all, HasSubstr("mm3"));
  EXPECT_THAT(all, HasSubstr("HU 100 to 250"));
}

TEST_F(Formats, VoxmapIsPlacedInWholeBricksWithAirAllRound) {
  for (const double voxel_mm : {0.3, 0.5, 1.0, 1.7}) {
    const FilledVoxmap voxmap = import(folder_.file("reference.nrrd"), voxel_mm);
    EXPECT_EQ(voxmap.grid.dims.x() % 8 + voxmap.grid.dims.y() % 8 + voxmap.grid.dims.z() % 8, 0);
    EXPECT_EQ(voxmap.grid.voxel_mm, voxel_mm);
    EXPECT_EQ(voxmap.frame, "LPS");
    int nearest = 1000;
    for_each_bone_voxel(voxmap, [&](const Vec3i& c, std::uint8_t, std::uint16_t) {
      nearest = std::min({nearest, c.minCoeff(), (voxmap.grid.dims - Vec3i::Ones() - c).minCoeff()});
    });
    EXPECT_GE(nearest, 3) << voxel_mm;
  }
}

}  // namespace
}  // namespace reamsim::test
