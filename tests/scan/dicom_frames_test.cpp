// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>

#include "dicom_bytes.h"
#include "dicom_fixture.h"

namespace reamsim::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Multi-frame files, segmentations and compressed pixels.
class DicomFramesTest : public Dicom {
 protected:
  void SetUp() override {
    Dicom::SetUp();
    fs::create_directory(folder_.file("cd"));
  }
  /// The threshold's bone of the egg as a mask.
  TestImage mask() const {
    TestImage out = egg_;
    for (double& value : out.value) value = value > 0 ? 1 : 0;
    return out;
  }
  FilledVoxmap import_label(const std::string& label) {
    BoneSettings with = settings("reference.nrrd");
    with.ct.label_map = LabelMapSettings{.path = folder_.file("seg.dcm"), .label = {label}};
    report_ = {};
    return voxmap_from_ct(with, report_);
  }
  std::string label_error(const std::string& label) {
    try {
      import_label(label);
    } catch (const InputError& error) {
      return error.what();
    }
    ADD_FAILURE() << "no error";
    return "";
  }
};

TEST_F(DicomFramesTest, AnEnhancedCtIsRead) {
  const EnhancedCt ways[] = {{},
                             {.orientation_per_frame = true, .rescale_per_frame = true},
                             {.reversed = true},
                             {.sop_class = "1.2.840.10008.5.1.4.1.1.2.2", .rescale_per_frame = true}};
  for (const EnhancedCt& way : ways) {
    write("cd/IM0001", enhanced_ct({egg_}, way));
    expect_egg("cd");
    EXPECT_THAT(report_.notes, Contains(AllOf(HasSubstr("DICOM series of 1 file, 24 frames, int16"))));
    EXPECT_THAT(report_.warnings, IsEmpty());
    expect_egg("cd/IM0001");
  }
  // In the same study as a scout and a series of single slices.
  write_dicom(cropped(egg_, {0, 0, 0}, {26, 30, 20}), folder_.file("cd/slices"), -1, {.series = "1.2.8"});
  expect_egg("cd");
}

TEST_F(DicomFramesTest, ATurnedEnhancedCtIsReadAsTheSlicesAre) {
  TestImage turned = egg_;
  const double angle = 0.2;
  turned.direction.col(0) = Vec3(std::cos(angle), std::sin(angle), 0);
  turned.direction.col(1) = Vec3(-std::sin(angle), std::cos(angle), 0);
  turned.sample(knobbed_egg);
  write_slices(turned, folder_.file("slices"));
  write("cd/IM0001", enhanced_ct({turned}, {}));
  expect_same(import("cd"), import("slices"), "turned");
}

TEST_F(DicomFramesTest, PhasesOfAnEnhancedCtAreChosen) {
  const auto index = [](unsigned n) { return element(0x20, 0x9128, "UL", ul(n)); };
  write("cd/IM0001", enhanced_ct({other(), egg_}, {.frame_content = {index(1), index(2)}}));
  EXPECT_THAT(error_of("cd"), HasSubstr("the series holds 2 volumes: 1/1: TemporalPositionIndex=1, 24 slices"));
  series_ = "1/2";
  expect_egg("cd");
  series_ = "1#TemporalPositionIndex=2";
  expect_egg("cd/IM0001");
  // Frames that no element tells apart: by their order.
  write("cd/IM0001", enhanced_ct({other(), egg_}, {}));
  series_ = "1/2";
  expect_egg("cd");
  // A file for each phase.
  write("cd/IM0001", enhanced_ct({other()}, {}));
  write("cd/IM0002", enhanced_ct({egg_}, {.instance = "1.2.3.10", .instance_number = 2}));
  series_ = "1#InstanceNumber=2";
  expect_egg("cd");
}

TEST_F(DicomFramesTest, ADamagedEnhancedCtIsRefused) {
  const std::string whole = enhanced_ct({egg_}, {});
  write("cd/IM0001", whole.substr(0, whole.size() - 3000));
  EXPECT_THAT(error_of("cd"), HasSubstr("IM0001"));
  for (std::size_t at = 200; at < whole.size() && at < 20'000; at += 997) {
    std::string broken = whole;
    broken[at] = static_cast<char>(broken[at] ^ 0x55);
    write("cd/IM0001", broken);
    try {
      import("cd");
    } catch (const InputError&) {  // an error, or the egg: never a crash
    }
  }
}

TEST_F(DicomFramesTest, ASegmentationIsReadByLabelAndNumber) {
  TestImage half = mask();
  for (std::size_t n = 0; n < half.value.size() / 2; ++n) half.value[n] = 0;
  write_image<std::uint8_t>(mask(), folder_.file("mask.nrrd"));
  BoneSettings with = settings("reference.nrrd");
  with.ct.label_map = LabelMapSettings{.path = folder_.file("mask.nrrd"), .label = {"1"}};
  const FilledVoxmap whole = voxmap_from_ct(with, report_);
  for (const std::string type : {"BINARY", "FRACTIONAL", "LABELMAP"}) {
    SCOPED_TRACE(type);
    const bool overlaps = type != "LABELMAP";
    TestImage rest = half;
    if (!overlaps) rest.value.assign(rest.value.size(), 0);
    write("seg.dcm",
          dicom_seg({{.number = 3, .label = "Hälfte", .mask = rest}, {.number = 5, .label = "Scapula", .mask = mask()}},
                    type));
    expect_same(import_label("scapula"), whole, "by name");
    expect_same(import_label("5"), whole, "by number");
    EXPECT_THAT(report_.notes, Contains(HasSubstr("DICOM SEG, 2 segments")));
    EXPECT_THAT(label_error("humerus"), HasSubstr("expected one of Hälfte, Scapula, or a label's number"));
    if (!overlaps) continue;
    EXPECT_LT(volume_mm3(import_label("Hälfte")), 0.8 * volume_mm3(whole));
  }
  fs::create_directory(folder_.file("seg"));
  fs::copy(folder_.file("seg.dcm"), folder_.file("seg/1.dcm"));
  with.ct.label_map = LabelMapSettings{.path = folder_.file("seg"), .label = {"Scapula"}};
  expect_same(voxmap_from_ct(with, report_), whole, "in a folder");
}

TEST_F(DicomFramesTest, SegmentsOfOneNameAreToldApartByTheirSide) {
  TestImage none = mask();
  none.value.assign(none.value.size(), 0);
  none.value[1000] = 1;
  write("seg.dcm", dicom_seg({{.number = 1, .label = "Scapula", .mask = none, .side = "Right"},
                              {.number = 2, .label = "Scapula", .mask = mask(), .side = "Left"}}));
  EXPECT_GT(volume_mm3(import_label("Scapula (left)")), 1000);
  EXPECT_THAT(label_error("Scapula"), HasSubstr("expected one of Scapula (Right), Scapula (Left)"));
}

TEST_F(DicomFramesTest, OtherDicomFilesAreNoSegmentation) {
  write_dicom(egg_, folder_.file("cd"));
  fs::copy(folder_.file("cd/slice003.dcm"), folder_.file("seg.dcm"));
  EXPECT_THAT(label_error("1"), HasSubstr("a DICOM file of modality CT, not a segmentation (SEG)"));
  fs::remove(folder_.file("seg.dcm"));
  write("seg.dcm",
        dicom_file("1.2.840.10008.5.1.4.1.1.481.3", "1.2.3",
                   element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.481.3") + element(8, 0x18, "UI", "1.2.3") +
                       element(8, 0x60, "CS", "RTSTRUCT") + element(0x20, 0xe, "UI", "1.2")));
  EXPECT_THAT(label_error("1"), HasSubstr("a DICOM RT structure set: contours, not voxels"));
  const std::string seg = dicom_seg({{.number = 1, .label = "Scapula", .mask = mask()}});
  write("seg.dcm", seg.substr(0, seg.size() - 500));
  EXPECT_THAT(label_error("1"), HasSubstr("seg.dcm"));
}

/// Rewrites the slices of a folder in a transfer syntax. False: GDCM cannot write it.
bool recode(const std::string& folder, gdcm::TransferSyntax::TSType type) {
  for (const auto& file : fs::directory_iterator(folder)) {
    gdcm::ImageReader reader;
    reader.SetFileName(file.path().c_str());
    if (!reader.Read()) return false;
    gdcm::ImageChangeTransferSyntax change;
    change.SetTransferSyntax(type);
    change.SetInput(reader.GetImage());
    if (!change.Change()) return false;
    gdcm::ImageWriter writer;
    writer.SetFileName(file.path().c_str());
    writer.SetFile(reader.GetFile());
    writer.SetImage(change.GetOutput());
    if (!writer.Write()) return false;
  }
  return true;
}

TEST_F(DicomFramesTest, CompressedPixelsAreRead) {
  using Syntax = gdcm::TransferSyntax;
  const std::pair<Syntax::TSType, bool> syntaxes[] = {{Syntax::JPEGLosslessProcess14, false},
                                                      {Syntax::JPEGLosslessProcess14_1, false},
                                                      {Syntax::JPEGLSLossless, false},
                                                      {Syntax::JPEG2000Lossless, false},
                                                      {Syntax::RLELossless, false},
                                                      {Syntax::DeflatedExplicitVRLittleEndian, false},
                                                      {Syntax::JPEG2000, true},
                                                      {Syntax::JPEGLSNearLossless, true}};
  for (const auto& [syntax, lossy] : syntaxes) {
    const std::string name = Syntax::GetTSString(syntax);
    SCOPED_TRACE(name);
    write_slices(egg_, folder_.file(name));
    if (!recode(folder_.file(name), syntax)) {
      ADD_FAILURE() << "GDCM does not write it";
      continue;
    }
    if (!lossy) {
      expect_egg(name);
      EXPECT_THAT(report_.warnings, IsEmpty());
      continue;
    }
    EXPECT_NEAR(volume_mm3(import(name)) / volume_mm3(reference_), 1, 0.01);
    EXPECT_THAT(report_.warnings, Contains(HasSubstr("24 of 24 slices were compressed with loss (")));
  }
}

TEST_F(DicomFramesTest, JpegOfEightAndTwelveBitsIsRead) {
  for (const unsigned bits : {8U, 12U}) {
    const std::string name = std::to_string(bits);
    TestImage stored = egg_;  // 0 to 250: no more than eight bits
    write_slices(stored, folder_.file(name),
                 {.more = {{0x00280101, element(0x28, 0x101, "US", us(bits))},
                           {0x00280102, element(0x28, 0x102, "US", us(bits - 1))},
                           {0x00280103, element(0x28, 0x103, "US", us(0))}}});
    if (bits == 8) continue;  // 16 allocated bits: not for baseline
    ASSERT_TRUE(recode(folder_.file(name), gdcm::TransferSyntax::JPEGExtendedProcess2_4));
    EXPECT_NEAR(volume_mm3(import(name)) / volume_mm3(reference_), 1, 0.06);
    EXPECT_THAT(report_.warnings, Contains(HasSubstr("24 of 24 slices were compressed with loss (")));
  }
}

TEST_F(DicomFramesTest, CodingsThatGdcmDoesNotHaveAreNamed) {
  const std::pair<const char*, const char*> codings[] = {
      {"1.2.840.10008.1.2.4.201", "High-Throughput JPEG 2000, HTJ2K (1.2.840.10008.1.2.4.201)"},
      {"1.2.840.10008.1.2.4.203", "HTJ2K (1.2.840.10008.1.2.4.203)"},
      {"1.2.840.10008.1.2.4.110", "JPEG XL (1.2.840.10008.1.2.4.110)"},
      {"1.2.840.10008.1.2.4.102", "video (MPEG) (1.2.840.10008.1.2.4.102)"},
      {"1.2.3.4.5.6.7", "coded as 1.2.3.4.5.6.7"}};
  for (const auto& [uid, words] : codings) {
    write("cd/IM0001",
          dicom_file("1.2.840.10008.5.1.4.1.1.2", "1.2.3.9", element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2"), uid));
    EXPECT_THAT(error_of("cd"),
                AllOf(HasSubstr(words), HasSubstr("GDCM cannot decode"), HasSubstr("as Explicit VR Little Endian")));
    EXPECT_THAT(error_of("cd/IM0001"), HasSubstr(words));
  }
  write("cd/IM0001", dicom_file("1.2.840.10008.5.1.4.1.1.2", "1.2.3.9",
                                element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2"), "1.2.840.10008.1.2.4.201"));
  EXPECT_THAT(error_of("cd"), HasSubstr("pydicom and pylibjpeg-openjpeg"));
  write_dicom(egg_, folder_.file("cd/a"));
  expect_egg("cd");
  EXPECT_THAT(report_.warnings, Contains(AllOf(HasSubstr("skipped: coded as"), HasSubstr("HTJ2K"))));
}

}  // namespace
}  // namespace reamsim::test
