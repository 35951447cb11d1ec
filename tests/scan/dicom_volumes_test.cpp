// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "dicom_bytes.h"
#include "dicom_fixture.h"

namespace reamsim::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Spacing, ends and volumes of a DICOM series.
class DicomVolumes : public Dicom {
 protected:
  /// The egg with another slice spacing, over the same height.
  TestImage with_spacing(double mm) const {
    TestImage out = egg_;
    out.spacing_mm.z() = mm;
    out.dims.z() = static_cast<int>(egg_.dims.z() * egg_.spacing_mm.z() / mm);
    out.sample(knobbed_egg);
    return out;
  }
  /// Slices `first` to the last of an image, each `stride`-th.
  static TestImage each(const TestImage& image, int first, int count, int stride) {
    TestImage out = cropped(image, {0, 0, first}, {image.dims.x(), image.dims.y(), 1});
    for (int n = 1; n < count; ++n) {
      const TestImage next = cropped(image, {0, 0, first + n * stride}, {image.dims.x(), image.dims.y(), 1});
      out.value.insert(out.value.end(), next.value.begin(), next.value.end());
    }
    out.dims.z() = count;
    out.spacing_mm.z() *= stride;
    return out;
  }
  /// Slices of 1 mm up to the middle, then of 2 mm.
  void write_changing(const std::string& name, const TestImage& fine) const {
    const int half = fine.dims.z() / 2;
    write_slices(each(fine, 0, half, 1), folder_.file(name));
    write_slices(each(fine, half + 1, (fine.dims.z() - half - 1) / 2, 2), folder_.file(name),
                 {.first_instance = half + 1});
  }
  /// Whether a folder gives the bone that these voxels give as an NRRD.
  void expect_as(const TestImage& image, const std::string& name, double tolerance = 0.01, double shift_mm = 0.1) {
    write_image<std::int16_t>(image, folder_.file("expected.nrrd"));
    BoneSettings with = settings("expected.nrrd");
    with.ct.series = "";
    const FilledVoxmap expected = voxmap_from_ct(with, report_);
    const FilledVoxmap found = import(name);
    EXPECT_NEAR(volume_mm3(found) / volume_mm3(expected), 1, tolerance) << name;
    EXPECT_LT((centroid_mm(found) - centroid_mm(expected)).norm(), shift_mm) << name;
  }
};

TEST_F(DicomVolumes, PositionsThatAnExporterRoundedAreEven) {
  for (const auto& [spacing, decimals] : {std::pair(0.625, 1), {0.625, 2}, {1.25, 1}, {0.7, 1}, {1.25, 3}}) {
    const std::string name = "cd" + std::to_string(spacing) + "_" + std::to_string(decimals);
    const std::string thickness = element(0x18, 0x50, "DS", numbers_text({spacing}));
    write_slices(with_spacing(spacing), folder_.file(name), {.decimals = decimals, .more = {{0x00180050, thickness}}});
    SCOPED_TRACE(name);
    expect_as(with_spacing(spacing), name);
    if (decimals == 1 && spacing == 0.625) {
      EXPECT_THAT(report_.warnings, Contains(AllOf(HasSubstr("slice positions are rounded or uneven"),
                                                   HasSubstr("from a spacing of 0.6250 mm"))));
      EXPECT_THAT(report_.notes, Contains(HasSubstr("x0.625 mm")));
    } else if (decimals == 3) {
      EXPECT_THAT(report_.warnings, IsEmpty());
    }
  }
}

TEST_F(DicomVolumes, AMissingSliceAmongRoundedPositionsIsFound) {
  write_slices(with_spacing(0.625), folder_.file("cd"), {.decimals = 1});
  fs::remove(folder_.file("cd/IM0021"));
  EXPECT_THAT(error_of("cd"),
              AllOf(HasSubstr("IM0020 and "), HasSubstr("IM0022"), HasSubstr("a slice is missing between them")));
  fs::remove(folder_.file("cd/IM0022"));
  EXPECT_THAT(error_of("cd"), HasSubstr("2 slices are missing between them"));
}

TEST_F(DicomVolumes, WholeMillimetresMayBeRoundedOrMissASlice) {
  // 1, 1, 1, 2, 1, 1, 1, 2: slices of 1.25 mm, as the header says, or slices of 1 mm with gaps.
  const std::string thick = element(0x18, 0x50, "DS", "1.25");
  write_slices(egg_, folder_.file("rounded"), {.decimals = 0, .more = {{0x00180050, thick}}});
  expect_as(egg_, "rounded", 0.03, 0.8);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("rounded or uneven")));
  const std::string thin = element(0x18, 0x50, "DS", "1");
  write_slices(egg_, folder_.file("gaps"), {.decimals = 0, .more = {{0x00180050, thin}}});
  EXPECT_THAT(error_of("gaps"), HasSubstr("a slice is missing between them"));
  write_slices(with_spacing(1), folder_.file("one"), {.decimals = 0});
  fs::remove(folder_.file("one/IM0013"));
  EXPECT_THAT(error_of("one"), HasSubstr("a slice is missing between them"));
}

TEST_F(DicomVolumes, AChangeOfSpacingIsCalledThatAndResampledOnRequest) {
  TestImage fine = with_spacing(1);
  write_changing("cd", fine);
  EXPECT_THAT(error_of("cd"), AllOf(HasSubstr("slice spacing changes from 1.000 to 2.000 mm at slice 16 of"),
                                    HasSubstr("IM0016"), HasSubstr("bone.ct.uneven: resample")));
  uneven_ = Uneven::resample;
  expect_as(fine, "cd", 0.06, 0.4);  // the edge of the egg is sharp, slices of 2 mm lose some of it
  EXPECT_THAT(report_.warnings, Contains(AllOf(HasSubstr("unevenly spaced (from here 2.000 mm, before 1.000 mm)"),
                                               HasSubstr("slices were interpolated to"))));
  // A tilted gantry: slices lie on a line that is not their normal.
  const TestImage straight = fine;
  fine.direction.col(2) = Vec3(0, 0.3, 1);
  fine.origin_mm.y() -= 0.15 * fine.dims.z();
  fine.sample(knobbed_egg);
  write_changing("tilted", fine);
  write_slices(fine, folder_.file("tilted_fine"));
  uneven_ = Uneven::refuse;
  const FilledVoxmap expected = import("tilted_fine");
  uneven_ = Uneven::resample;
  EXPECT_NEAR(volume_mm3(import("tilted")) / volume_mm3(expected), 1, 0.06);
  uneven_ = Uneven::refuse;
  EXPECT_THAT(error_of("tilted"), HasSubstr("slice spacing changes from 1.000 to 2.000 mm"));
  // Thicker slices first, and one that is missing: with the key, it is interpolated and named.
  uneven_ = Uneven::resample;
  write_slices(straight, folder_.file("gap"));
  fs::remove(folder_.file("gap/IM0010"));
  expect_as(straight, "gap", 0.03);
  EXPECT_THAT(report_.warnings,
              Contains(AllOf(HasSubstr("IM0011"), HasSubstr("a slice is missing before it (a gap of 2.000 mm)"))));
}

TEST_F(DicomVolumes, ResamplingEvenSlicesChangesNothing) {
  write_dicom(egg_, folder_.file("cd"));
  uneven_ = Uneven::resample;
  expect_egg("cd");
  EXPECT_THAT(report_.warnings, IsEmpty());
}

struct Separation {
  unsigned tag;
  std::string vr;
  std::string keyword;
  std::string first;
  std::string second;
};

TEST_F(DicomVolumes, VolumesAreToldApartByTheElementThatSeparatesThem) {
  const Separation separations[] = {
      {0x00200012, "IS", "AcquisitionNumber", "1", "2"},
      {0x00200100, "IS", "TemporalPositionIdentifier", "9", "10"},
      {0x00181060, "DS", "TriggerTime", "75.5", "250"},
      {0x00180086, "IS", "EchoNumbers", "1", "2"},
      {0x00209241, "FL", "NominalPercentageOfCardiacPhase", "30", "70.5"},
      {0x00181210, "SH", "ConvolutionKernel", "B30f", "B60s"},
      {0x00080008, "CS", "ImageType", "ORIGINAL\\PRIMARY\\AXIAL", "ORIGINAL\\PRIMARY\\AXIAL\\MPR"},
      {0x00180060, "DS", "KVP", "100", "140"},
      {0x00080032, "TM", "AcquisitionTime", "101500.1", "101501.2"},
      {0x00080033, "TM", "ContentTime", "101500.1", "101501.2"}};
  for (const Separation& s : separations) {
    SCOPED_TRACE(s.keyword);
    const auto more = [&](const std::string& value) {
      const float number = s.vr == "FL" ? std::stof(value) : 0;
      const std::string bytes(reinterpret_cast<const char*>(&number), sizeof number);
      return DicomElements{{s.tag, element(s.tag >> 16, s.tag & 0xffff, s.vr, s.vr == "FL" ? bytes : value)}};
    };
    const std::string name = s.keyword;
    write_slices(egg_, folder_.file(name), {.more = more(s.first)});
    write_slices(other(), folder_.file(name), {.first_instance = 25, .more = more(s.second)});
    series_ = "";
    EXPECT_THAT(error_of(name),
                AllOf(HasSubstr("bone.ct.series: the series holds 2 volumes: 1/1: " + s.keyword + "=" + s.first +
                                ", 24 slices of 26x30, 1x1x1.25 mm; 1/2: " + s.keyword + "=" + s.second),
                      HasSubstr("for example 1/1 or 1#" + s.keyword + "=" + s.first)));
    series_ = "1/1";
    expect_egg(name);
    series_ = "1.2.3.4#" + s.keyword + "=" + s.first;
    expect_egg(name);
    series_ = "1#" + s.keyword + "=" + s.second;
    const FilledVoxmap second = import(name);
    EXPECT_NEAR(centroid_mm(second).x() - centroid_mm(reference_).x(), -2, 0.01);
    series_ = "1/2";
    expect_same(import(name), second, "by number");
  }
  series_ = "1/3";
  EXPECT_THAT(error_of("KVP"), HasSubstr("no volume 3 in the series; expected one of 1/1: KVP=100"));
  series_ = "1#KVP=120";
  EXPECT_THAT(error_of("KVP"), HasSubstr("no slice has KVP=120; its values are 100, 140"));
  series_ = "1#Colour=red";
  EXPECT_THAT(error_of("KVP"), HasSubstr("'Colour' is no element by which volumes are told apart"));
  for (const std::string wrong : {"1/", "1/x", "1/0", "1#KVP", "1/-1"}) {
    series_ = wrong;
    EXPECT_THAT(error_of("KVP"), HasSubstr("bone.ct.series: found '" + wrong + "'"));
  }
}

TEST_F(DicomVolumes, TwoElementsTogetherTellFourVolumesApart) {
  int first = 1;
  for (const std::string phase : {"1", "2"}) {
    for (const std::string kernel : {"B30f", "B60s"}) {
      const bool wanted = phase == "2" && kernel == "B30f";
      write_slices(wanted ? egg_ : other(), folder_.file("cd"),
                   {.first_instance = first,
                    .more = {{0x00200012, element(0x20, 0x12, "IS", phase)},
                             {0x00181210, element(0x18, 0x1210, "SH", kernel)}}});
      first += 24;
    }
  }
  EXPECT_THAT(error_of("cd"), AllOf(HasSubstr("the series holds 4 volumes"),
                                    HasSubstr("1/3: AcquisitionNumber=2#ConvolutionKernel=B30f, 24 slices")));
  series_ = "1/3";
  expect_egg("cd");
  series_ = "1#ConvolutionKernel=B30f#AcquisitionNumber=2";
  expect_egg("cd");
  series_ = "1#AcquisitionNumber=2";
  EXPECT_THAT(error_of("cd"), HasSubstr("the series holds 2 volumes: 1/1: ConvolutionKernel=B30f"));
}

TEST_F(DicomVolumes, WithoutAnElementTheInstanceNumbersTellThemApart) {
  write_slices(egg_, folder_.file("cd"));
  write_slices(other(), folder_.file("cd"), {.first_instance = 25});
  EXPECT_THAT(error_of("cd"), AllOf(HasSubstr("1/1: InstanceNumber 1 to 24, 24 slices"),
                                    HasSubstr("1/2: InstanceNumber 25 to 48"), HasSubstr("for example 1/1")));
  series_ = "1/1";
  expect_egg("cd");
}

TEST_F(DicomVolumes, VolumesWhoseSlicesAlternateAreNotMixed) {
  TestImage shifted = egg_;
  shifted.origin_mm.z() += 0.4;
  shifted.sample(knobbed_egg);
  write_slices(egg_, folder_.file("cd"), {.more = {{0x00181210, element(0x18, 0x1210, "SH", "B30f")}}});
  write_slices(shifted, folder_.file("cd"),
               {.first_instance = 25, .more = {{0x00181210, element(0x18, 0x1210, "SH", "B60s")}}});
  EXPECT_THAT(error_of("cd"), HasSubstr("the series holds 2 volumes: 1/1: ConvolutionKernel=B30f"));
  series_ = "1/1";
  expect_egg("cd");
  // Halfway, the two are evenly spaced together.
  shifted.origin_mm.z() = egg_.origin_mm.z() + 0.625;
  shifted.sample(knobbed_egg);
  write_slices(shifted, folder_.file("cd"),
               {.first_instance = 25, .more = {{0x00181210, element(0x18, 0x1210, "SH", "B60s")}}});
  series_ = "";
  import("cd");
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("alternate between ConvolutionKernel B30f and B60s")));
}

TEST_F(DicomVolumes, StacksOfOneSizeAreVolumesToo) {
  TestImage wide = cropped(egg_, {0, 0, 0}, {26, 28, 24});
  write_slices(egg_, folder_.file("cd"));
  write_slices(wide, folder_.file("cd"), {.first_instance = 25});
  EXPECT_THAT(error_of("cd"), AllOf(HasSubstr("1/1: 24 slices of 26x30"), HasSubstr("1/2: 24 slices of 26x28")));
  series_ = "1/1";
  expect_egg("cd");
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("images of the DICOM series skipped: 24")));
}

TEST_F(DicomVolumes, SlicesMissingAtTheEndsAreNamed) {
  write_slices(egg_, folder_.file("cd"), {.more = {{0x00201002, element(0x20, 0x1002, "IS", "24")}}});
  expect_egg("cd");
  EXPECT_THAT(report_.warnings, IsEmpty());
  for (const char* file : {"cd/IM0001", "cd/IM0002", "cd/IM0023", "cd/IM0024"}) fs::remove(folder_.file(file));
  import("cd");
  EXPECT_THAT(report_.warnings,
              Contains(AllOf(HasSubstr("slices are missing at the ends"), HasSubstr("instances 1 to 2 before "),
                             HasSubstr("IM0003"), HasSubstr("instances 23 to 24 after "), HasSubstr("IM0022"))));
  // A scout in the series has the number that seems to be missing.
  write_slices(egg_, folder_.file("scout"), {.first_instance = 2});
  write_slices(cropped(egg_, {0, 0, 0}, {20, 30, 1}), folder_.file("scout"));
  expect_egg("scout");
  EXPECT_THAT(report_.warnings, testing::Not(Contains(HasSubstr("missing at the ends"))));
}

}  // namespace
}  // namespace reamsim::test
