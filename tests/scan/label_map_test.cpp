// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/segment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/scan/ct_import.h"
#include "test_images.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kShell = 5;
constexpr int kKnob = 9;

/// Labels of the knobbed egg: the egg, and the knob on it.
double egg_labels(const Vec3& p) {
  const Vec3 q = p - Vec3(-20, 35, 110);
  if (q.cwiseQuotient(Vec3(9, 11, 10)).norm() <= 1) return kShell;
  return (q - Vec3(5, 7, 6)).norm() <= 3.5 ? kKnob : 0;
}

class LabelMap : public ::testing::Test {
 protected:
  void SetUp() override {
    write_image<std::int16_t>(egg_image(), folder_.file("ct.nrrd"));
    labels_ = egg_image();
    labels_.sample(egg_labels);
    write_image<std::uint8_t>(labels_, folder_.file("plain.nrrd"));
    reference_ = import("plain.nrrd", {"5"});
    ASSERT_GT(volume_mm3(reference_), 3000);
    report_ = {};
  }

  BoneSettings settings(const std::string& name, const std::vector<std::string>& label) const {
    BoneSettings out = settings_for(folder_.file("ct.nrrd"), 0.7);
    out.surface_voxels = SurfaceVoxels::partial;
    out.ct.label_map = LabelMapSettings{.path = folder_.file(name), .label = label};
    return out;
  }
  FilledVoxmap import(const std::string& name, const std::vector<std::string>& label) {
    return voxmap_from_ct(settings(name, label), report_);
  }
  void expect_reference(const std::string& name, const std::vector<std::string>& label) {
    const FilledVoxmap voxmap = import(name, label);
    expect_same(voxmap, reference_, name);
    EXPECT_EQ(voxmap.grid.origin_mm, reference_.grid.origin_mm) << name;
    EXPECT_TRUE(dense_fill(voxmap) == dense_fill(reference_)) << name;
  }
  std::string error_of(const BoneSettings& bone) {
    try {
      voxmap_from_ct(bone, report_);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return "";
  }
  std::string error_of(const std::string& name, const std::vector<std::string>& label) {
    return error_of(settings(name, label));
  }

  TempFolder folder_;
  TestImage labels_;
  FilledVoxmap reference_;
  Diagnostics report_;
};

TEST_F(LabelMap, EveryOrderAndSenseOfTheAxesIsTheSameMap) {
  std::array<int, 3> axes{0, 1, 2};
  int cases = 0;
  const std::array<std::string, 3> endings{".nrrd", ".nii.gz", ".mha"};
  do {
    for (int bits = 0; bits < 8; ++bits) {
      const std::array<bool, 3> flip{(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
      const std::string name = "flip" + std::to_string(cases) + endings[static_cast<std::size_t>(cases) % 3];
      write_image<std::uint8_t>(reordered(labels_, axes, flip), folder_.file(name));
      expect_reference(name, {"5"});
      ++cases;
    }
  } while (std::next_permutation(axes.begin(), axes.end()));
  EXPECT_EQ(cases, 48);
}

TEST_F(LabelMap, CroppedMapsAreTheSameMap) {
  const TestImage tight = cropped(labels_, {2, 2, 2}, {22, 26, 21});
  write_image<std::uint8_t>(tight, folder_.file("tight.nrrd"));
  expect_reference("tight.nrrd", {"5"});
  write_image<std::int16_t>(reordered(tight, {2, 0, 1}, {true, true, false}), folder_.file("tight.nii"));
  expect_reference("tight.nii", {"5"});
  // Larger than the image, and off by less than a header's digits.
  TestImage large = labels_;
  large.dims += Vec3i(7, 5, 3);
  large.origin_mm -= Vec3(4, 2, 1.25) - Vec3(0.003, -0.003, 0.003);
  large.sample([](const Vec3& p) { return egg_labels((p - Vec3(0.003, -0.003, 0.003)).eval()); });
  write_image<std::uint8_t>(large, folder_.file("large.nrrd"));
  expect_reference("large.nrrd", {"5"});
  EXPECT_TRUE(report_.warnings.empty()) << report_.warnings.front();
}

TEST_F(LabelMap, FloatingPointTypesHoldLabelsToo) {
  write_image<float>(labels_, folder_.file("float.nii"));
  write_image<double>(labels_, folder_.file("double.nrrd"));
  expect_reference("float.nii", {"5"});
  expect_reference("double.nrrd", {"5"});
  TestImage odd = labels_;
  odd.value[odd.value.size() / 2] = 4.5;
  write_image<float>(odd, folder_.file("odd.nii"));
  EXPECT_THAT(error_of("odd.nii", {"5"}), AllOf(HasSubstr("odd.nii: bone.ct.label_map.path: the value 4.5 at voxel ("),
                                                HasSubstr("is not a label; expected whole numbers")));
}

/// The two labels in layers of their own, both with the value 1, as 3D Slicer stores segments that may overlap.
std::vector<TestImage> layers_of(const TestImage& labels) {
  TestImage knob = labels;
  TestImage shell = labels;
  for (double& value : knob.value) value = value == kKnob ? 1 : 0;
  for (double& value : shell.value) value = value == kShell ? 1 : 0;
  return {knob, shell};
}

constexpr const char* kSegments =
    "Segment0_ID:=Segment_1\nSegment0_Name:=Knob\nSegment0_Layer:=0\nSegment0_LabelValue:=1\n"
    "Segment0_Extent:=0 21 0 25 0 20\n"
    "Segment1_ID:=Segment_2\nSegment1_Name:=scapula_left\nSegment1_Layer:=1\nSegment1_LabelValue:=1\n"
    "Segmentation_ReferenceImageExtentOffset:=2 2 2\n";

TEST_F(LabelMap, LayeredSegNrrdOfSlicer) {
  write_seg_nrrd(layers_of(labels_), folder_.file("layers.seg.nrrd"), kSegments);
  expect_reference("layers.seg.nrrd", {"scapula_left"});
  expect_reference("layers.seg.nrrd", {"Scapula_Left"});
  write_seg_nrrd(layers_of(cropped(labels_, {2, 2, 2}, {22, 26, 21})), folder_.file("cropped.seg.nrrd"), kSegments);
  expect_reference("cropped.seg.nrrd", {"scapula_left"});
  EXPECT_THAT(error_of("layers.seg.nrrd", {"humerus"}), HasSubstr("expected one of Knob, scapula_left"));
  EXPECT_THAT(error_of("layers.seg.nrrd", {"1"}), HasSubstr("label 1 stands for 2 segments"));
  write_seg_nrrd(layers_of(labels_), folder_.file("unnamed.nrrd"), "");
  EXPECT_THAT(error_of("unnamed.nrrd", {"1"}), HasSubstr("label 1 of a label map with 2 layers, none of them named"));
}

TEST_F(LabelMap, LayersAlongTheLastAxis) {
  // As pynrrd writes them: the list is the last axis, and the slowest.
  const std::vector<TestImage> layers = layers_of(labels_);
  std::string text =
      "NRRD0004\ntype: unsigned char\ndimension: 4\nspace: left-posterior-superior\nsizes: 26 30 24 2\n"
      "space directions: (1,0,0) (0,1,0) (0,0,1.25) none\nkinds: domain domain domain list\nencoding: raw\n"
      "space origin: (-32.5,20.25,96)\n" +
      std::string(kSegments) + "\n";
  for (const TestImage& layer : layers) {
    for (const double value : layer.value) text.push_back(static_cast<char>(value));
  }
  std::ofstream(folder_.file("last.seg.nrrd"), std::ios::binary) << text;
  expect_reference("last.seg.nrrd", {"scapula_left"});
}

TEST_F(LabelMap, ThreeDimensionalSegNrrd) {
  write_seg_nrrd({labels_}, folder_.file("flat.seg.nrrd"),
                 "Segment0_ID:=a\nSegment0_Name:=scapula_left\nSegment0_Layer:=0\nSegment0_LabelValue:=5\n"
                 "Segment1_ID:=b\nSegment1_Name:=knob\nSegment1_Layer:=0\nSegment1_LabelValue:=9\n");
  expect_reference("flat.seg.nrrd", {"scapula_left"});
  expect_reference("flat.seg.nrrd", {"5"});
}

TEST_F(LabelMap, NamesInANiftiExtension) {
  write_image<std::uint8_t>(labels_, folder_.file("total.nii"));
  std::string xml =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?><CaretExtension><VolumeInformation Index=\"0\"><LabelTable>"
      "<Label Key=\"9\" Red=\"1\">humerus_left</Label>\n<Label Key=\"5\" Red=\"0\"><![CDATA[scapula_left]]></Label>"
      "</LabelTable></VolumeInformation></CaretExtension>";
  constexpr std::size_t kHeader = 348, kVoxOffset = 108, kBlock = 16;
  constexpr std::int32_t kCaret = 30;  // NIFTI_ECODE_CARET
  xml.resize((8 + xml.size() + kBlock - 1) / kBlock * kBlock - 8, '\0');
  const std::int32_t head[] = {static_cast<std::int32_t>(8 + xml.size()), kCaret};
  std::string bytes = read_file(folder_.file("total.nii"), "a file");
  bytes[kHeader] = 1;  // extensions follow
  const auto offset = static_cast<float>(kHeader + 4 + 8 + xml.size());
  std::memcpy(bytes.data() + kVoxOffset, &offset, sizeof offset);
  bytes.insert(kHeader + 4, std::string(reinterpret_cast<const char*>(head), sizeof head) + xml);
  std::ofstream(folder_.file("named.nii"), std::ios::binary) << bytes;
  expect_reference("named.nii", {"scapula_left"});
  EXPECT_THAT(error_of("named.nii", {"clavicle"}), HasSubstr("expected one of humerus_left, scapula_left"));
}

TEST_F(LabelMap, SeveralLabelsAreOneBone) {
  TestImage one = labels_;
  for (double& value : one.value) value = value > 0 ? 1 : 0;
  write_image<std::uint8_t>(one, folder_.file("one.nrrd"));
  const FilledVoxmap whole = import("one.nrrd", {"1"});
  const FilledVoxmap several = import("plain.nrrd", {"5", "9"});
  expect_same(several, whole, "both");
  EXPECT_TRUE(dense_fill(several) == dense_fill(whole));
  EXPECT_GT(volume_mm3(several), volume_mm3(reference_) + 50);
  write_seg_nrrd(layers_of(labels_), folder_.file("layers.seg.nrrd"), kSegments);
  expect_same(import("layers.seg.nrrd", {"knob", "scapula_left"}), whole, "over layers");
}

/// The lattice of the image, `fineness` times as fine.
TestImage refined_grid(const TestImage& image, int fineness) {
  TestImage out = image;
  out.dims *= fineness;
  out.spacing_mm /= fineness;
  out.origin_mm += 0.5 * (out.spacing_mm - image.spacing_mm);
  return out;
}

TEST_F(LabelMap, CoarserAndFinerMapsGiveTheVolume) {
  TestImage fine = refined_grid(labels_, 3);
  fine.sample(egg_labels);
  write_image<std::uint8_t>(fine, folder_.file("fine.nrrd"));
  EXPECT_NEAR(import("fine.nrrd", {"5"}).bone_mm3() / reference_.bone_mm3(), 1, 0.001);
  TestImage half = labels_;
  half.dims /= 2;
  half.spacing_mm *= 2;
  half.origin_mm += 0.25 * half.spacing_mm;
  half.sample(egg_labels);
  write_image<std::uint8_t>(half, folder_.file("half.nrrd"));
  const FilledVoxmap voxmap = import("half.nrrd", {"5"});
  // Against what the coarse map itself says, sampled at its centres.
  const auto labelled_mm3 = [](const TestImage& image) {
    return static_cast<double>(std::ranges::count(image.value, kShell)) * image.spacing_mm.prod();
  };
  EXPECT_NEAR(voxmap.bone_mm3() / reference_.bone_mm3(), labelled_mm3(half) / labelled_mm3(labels_), 0.01);
  EXPECT_LT((centroid_mm(voxmap) - centroid_mm(reference_)).norm(), 0.2);
}

TEST_F(LabelMap, HalfwayPointsDoNotDependOnHowTheMapIsStored) {
  // Displaced by half a voxel, every point lies halfway between two.
  TestImage displaced = labels_;
  displaced.origin_mm += 0.5 * displaced.spacing_mm;
  displaced.sample(egg_labels);
  write_image<std::uint8_t>(displaced, folder_.file("displaced.nrrd"));
  const FilledVoxmap voxmap = import("displaced.nrrd", {"5"});
  for (const std::array<bool, 3>& flip : {std::array{true, true, true}, std::array{false, true, false}}) {
    write_image<std::uint8_t>(reordered(displaced, {1, 2, 0}, flip), folder_.file("flipped.nii"));
    expect_same(import("flipped.nii", {"5"}), voxmap, "flipped");
  }
}

TEST_F(LabelMap, ObliqueMapOfAStraightImage) {
  TestImage oblique;
  oblique.dims = {90, 90, 90};
  oblique.spacing_mm = Vec3::Constant(0.5);
  oblique.direction = Eigen::AngleAxisd(0.5, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  oblique.origin_mm = Vec3(-20, 35, 110) - oblique.direction * Vec3::Constant(22.25);
  oblique.sample(egg_labels);
  write_image<std::uint8_t>(oblique, folder_.file("oblique.nrrd"));
  EXPECT_NEAR(import("oblique.nrrd", {"5"}).bone_mm3() / reference_.bone_mm3(), 1, 0.01);
}

TEST_F(LabelMap, AMapOfAnotherPlaceGivesBothBoxes) {
  TestImage elsewhere = labels_;
  elsewhere.origin_mm = -labels_.origin_mm;
  write_image<std::uint8_t>(elsewhere, folder_.file("elsewhere.nrrd"));
  EXPECT_THAT(error_of("elsewhere.nrrd", {"5"}),
              AllOf(HasSubstr("bone.ct.label_map.path: the label map does not overlap the image: it spans (32.0, "
                              "-20.8, -96.6) to (58.0, 9.2, -66.6) mm"),
                    HasSubstr("the image spans (-33.0, 19.8, 95.4) to (-7.0, 49.8, 125.4) mm")));
  // One that meets the image, but not the crop.
  write_image<std::uint8_t>(cropped(labels_, {0, 0, 0}, {26, 30, 6}), folder_.file("low.nrrd"));
  BoneSettings crop = settings("low.nrrd", {"5"});
  crop.ct.crop_min_mm = Vec3(-40, 0, 110);
  crop.ct.crop_max_mm = Vec3(0, 60, 130);
  EXPECT_THAT(error_of(crop), HasSubstr("cropped to"));
}

TEST_F(LabelMap, AMapThatCutsTheBoneOffIsWarnedOf) {
  write_image<std::uint8_t>(cropped(labels_, {0, 0, 0}, {26, 30, 12}), folder_.file("short.nrrd"));
  EXPECT_LT(volume_mm3(import("short.nrrd", {"5"})), 0.6 * volume_mm3(reference_));
  ASSERT_EQ(report_.warnings.size(), 1U);
  EXPECT_THAT(report_.warnings[0], AllOf(HasSubstr("short.nrrd: the label touches the border of the map over"),
                                         HasSubstr("the map truncates the bone there")));
  // Cut where the image itself ends: nothing that the map lacks.
  report_ = {};
  BoneSettings crop = settings("short.nrrd", {"5"});
  crop.ct.crop_max_mm = Vec3(0, 60, 110);
  voxmap_from_ct(crop, report_);
  EXPECT_TRUE(report_.warnings.empty());
}

TEST_F(LabelMap, WhatIsNoLabelMap) {
  EXPECT_THAT(error_of(".", {"5"}), HasSubstr("no DICOM segmentation (SEG) in this folder; give a label map"));
  std::ofstream(folder_.file("text.nrrd")) << "no image";
  EXPECT_THAT(error_of("text.nrrd", {"5"}), HasSubstr("text.nrrd: bone.ct.label_map.path"));
  EXPECT_THAT(error_of("plain.nrrd", {"7"}), HasSubstr("no voxel in the crop has label 7; the map holds 5, 9 there"));
  EXPECT_THAT(error_of("plain.nrrd", {"scapula"}), HasSubstr("the label map names no segments"));
}

}  // namespace
}  // namespace reamsim::test
