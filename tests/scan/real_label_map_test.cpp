// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <itkNrrdImageIO.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "sim/scan/ct_import.h"
#include "test_images.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

/// The real shoulder's bone above 200 HU as label maps of every kind.
class RealLabelMap : public ::testing::Test {
 protected:
  static std::string scan_path() { return data_file("shoulder_ct/shoulder_left.nrrd"); }

  static void SetUpTestSuite() {
    if (!std::filesystem::exists(scan_path())) return;
    shared_ = std::make_unique<Shared>();
    shared_->labels = read_scan();
    for (double& value : shared_->labels.value) value = value >= 200 ? 12 : 0;
    write_image<std::uint8_t>(shared_->labels, shared_->folder.file("plain.nrrd"));
    shared_->reference = import("plain.nrrd", {"12"});
  }
  static void TearDownTestSuite() { shared_.reset(); }
  void SetUp() override {
    if (!shared_) GTEST_SKIP() << "no " << scan_path() << "; set REAMSIM_DATA";
  }

  static TestImage read_scan() {
    const auto io = itk::NrrdImageIO::New();
    io->SetFileName(scan_path());
    io->ReadImageInformation();
    TestImage out;
    itk::ImageIORegion region(3);
    for (unsigned axis = 0; axis < 3; ++axis) {
      out.dims[axis] = static_cast<int>(io->GetDimensions(axis));
      out.spacing_mm[axis] = io->GetSpacing(axis);
      out.origin_mm[axis] = io->GetOrigin(axis);
      region.SetSize(axis, io->GetDimensions(axis));
      const std::vector<double> direction = io->GetDirection(axis);
      for (int row = 0; row < 3; ++row) out.direction(row, axis) = direction[static_cast<std::size_t>(row)];
    }
    std::vector<std::int16_t> hu(static_cast<std::size_t>(out.dims.prod()));
    io->SetIORegion(region);
    io->Read(hu.data());
    out.value.assign(hu.begin(), hu.end());
    return out;
  }

  static FilledVoxmap import(const std::string& name, const std::vector<std::string>& label) {
    BoneSettings settings = settings_for(scan_path(), 0.8);
    settings.surface_voxels = SurfaceVoxels::partial;
    settings.ct.crop_min_mm = Vec3(85, 140, -480);  // round the glenoid
    settings.ct.crop_max_mm = Vec3(150, 205, -415);
    settings.ct.label_map = LabelMapSettings{.path = shared_->folder.file(name), .label = label};
    Diagnostics report;
    return voxmap_from_ct(settings, report);
  }
  static void expect_reference(const std::string& name, const std::vector<std::string>& label) {
    const FilledVoxmap voxmap = import(name, label);
    expect_same(voxmap, shared_->reference, name);
    EXPECT_TRUE(dense_fill(voxmap) == dense_fill(shared_->reference)) << name;
  }

  struct Shared {
    TempFolder folder;
    TestImage labels;
    FilledVoxmap reference;
  };
  static inline std::unique_ptr<Shared> shared_;
};

TEST_F(RealLabelMap, FlippedCroppedLayeredAndNamedMapsGiveTheSameBytes) {
  const TestImage& labels = shared_->labels;
  const TempFolder& folder = shared_->folder;
  EXPECT_GT(shared_->reference.bone_mm3(), 20e3);
  write_image<std::uint8_t>(reordered(labels, {0, 1, 2}, {true, true, false}), folder.file("ras.nii.gz"));
  expect_reference("ras.nii.gz", {"12"});
  write_image<std::uint8_t>(reordered(labels, {2, 0, 1}, {false, true, true}), folder.file("turned.mha"));
  expect_reference("turned.mha", {"12"});
  const TestImage part = cropped(labels, {10, 20, 30}, {180, 190, 135});
  write_image<std::uint8_t>(part, folder.file("cropped.nrrd"));
  expect_reference("cropped.nrrd", {"12"});
  TestImage none = part;
  std::fill(none.value.begin(), none.value.end(), 0.0);
  write_seg_nrrd({none, part}, folder.file("layers.seg.nrrd"),
                 "Segment0_Name:=lung\nSegment0_Layer:=0\nSegment0_LabelValue:=12\n"
                 "Segment1_Name:=scapula_left\nSegment1_Layer:=1\nSegment1_LabelValue:=12\n");
  expect_reference("layers.seg.nrrd", {"scapula_left"});
}

TEST_F(RealLabelMap, HalfTheResolutionGivesTheVolumeWithinAPercent) {
  const TestImage& labels = shared_->labels;
  // Each coarse voxel takes the label that most of its eight voxels have; every other one of an even split takes it.
  TestImage half = cropped(labels, {0, 0, 0}, labels.dims / 2);
  half.spacing_mm *= 2;
  half.origin_mm = labels.point_mm(0, 0, 0) + 0.5 * labels.direction * labels.spacing_mm;
  std::size_t at = 0;
  for (int k = 0; k < half.dims.z(); ++k) {
    for (int j = 0; j < half.dims.y(); ++j) {
      for (int i = 0; i < half.dims.x(); ++i, ++at) {
        int count = 0;
        for (int corner = 0; corner < 8; ++corner) {
          const Vec3i c = 2 * Vec3i(i, j, k) + Vec3i(corner & 1, corner >> 1 & 1, corner >> 2);
          count +=
              labels.value[static_cast<std::size_t>(c.x() + labels.dims.x() * (c.y() + labels.dims.y() * c.z()))] != 0;
        }
        half.value[at] = count > 4 || (count == 4 && (i + j + k) % 2 == 0) ? 12 : 0;
      }
    }
  }
  write_image<std::uint8_t>(half, shared_->folder.file("half.nrrd"));
  const FilledVoxmap voxmap = import("half.nrrd", {"12"});
  const double ratio = voxmap.bone_mm3() / shared_->reference.bone_mm3();
  std::cout << "half resolution: volume " << 100 * (ratio - 1) << " %\n";
  EXPECT_NEAR(ratio, 1, 0.01);
}

}  // namespace
}  // namespace reamsim::test
