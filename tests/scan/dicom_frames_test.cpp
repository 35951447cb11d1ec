// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#include <gdcmWriter.h>
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

/// Compresses the frames of a segmentation, each by itself, as highdicom does. False: GDCM cannot write it. GDCM's
/// image reader is not used, since it knows no label maps. `bits` of a pixel, and those that are stored.
bool recode_seg(const std::string& path, gdcm::TransferSyntax::TSType type, const TestImage& frame, unsigned bits,
                unsigned stored) {
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.Read()) return false;
  gdcm::DataSet& data = reader.GetFile().GetDataSet();
  const gdcm::Tag pixels(0x7fe0, 0x0010);
  if (type != gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian) {
    const unsigned plane = static_cast<unsigned>(frame.dims.x() * frame.dims.y()) * bits / 8;
    const gdcm::SmartPointer<gdcm::Image> image = new gdcm::Image;
    image->SetNumberOfDimensions(3);
    image->SetDimension(0, static_cast<unsigned>(frame.dims.x()));
    image->SetDimension(1, static_cast<unsigned>(frame.dims.y()));
    image->SetDimension(2, data.GetDataElement(pixels).GetByteValue()->GetLength() / plane);
    gdcm::PixelFormat format(bits == 8 ? gdcm::PixelFormat::UINT8 : gdcm::PixelFormat::UINT16);
    format.SetBitsStored(static_cast<unsigned short>(stored));
    format.SetHighBit(static_cast<unsigned short>(stored - 1));
    image->SetPixelFormat(format);
    image->SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
    image->SetTransferSyntax(gdcm::TransferSyntax::ExplicitVRLittleEndian);
    image->SetDataElement(data.GetDataElement(pixels));
    gdcm::ImageChangeTransferSyntax change;
    change.SetTransferSyntax(type);
    change.SetInput(*image);
    if (!change.Change()) return false;
    data.Replace(change.GetOutput().GetDataElement());
  }
  reader.GetFile().GetHeader().SetDataSetTransferSyntax(type);
  gdcm::Writer writer;
  writer.SetFileName(path.c_str());
  writer.SetFile(reader.GetFile());
  return writer.Write();
}

TEST_F(DicomFramesTest, CompressedSegmentationsAreRead) {
  using Syntax = gdcm::TransferSyntax;
  TestImage half = mask();
  for (std::size_t n = 0; n < half.value.size() / 2; ++n) half.value[n] = 0;
  const std::vector<TestSegment> segments{{.number = 3, .label = "Rest", .mask = half},
                                          {.number = 5, .label = "Scapula", .mask = mask()}};
  write("seg.dcm", dicom_seg(segments));
  const FilledVoxmap rest = import_label("Rest"), scapula = import_label("Scapula");
  const std::string path = folder_.file("seg.dcm");
  for (const Syntax::TSType syntax : {Syntax::RLELossless, Syntax::JPEGLSLossless, Syntax::JPEG2000Lossless,
                                      Syntax::JPEGLosslessProcess14_1, Syntax::DeflatedExplicitVRLittleEndian}) {
    for (const auto& [type, bits] :
         {std::pair<std::string, unsigned>{"BINARY", 1}, {"FRACTIONAL", 8}, {"LABELMAP", 8}, {"LABELMAP", 16}}) {
      SCOPED_TRACE(fmt::format("{} {} {}", Syntax::GetTSString(syntax), type, bits));
      std::vector<TestSegment> stored = segments;
      if (bits == 16) stored[0].number = 700;
      if (type == "LABELMAP") {  // whose segments do not overlap
        for (std::size_t n = 0; n < half.value.size(); ++n) stored[1].mask.value[n] -= half.value[n];
      }
      // Single bits are compressed as samples of one bit (JPEG 2000) or as bytes.
      const bool single_bits = bits == 1 && syntax != Syntax::DeflatedExplicitVRLittleEndian;
      const unsigned bytes = std::max(bits, 8U), sample = syntax == Syntax::JPEG2000Lossless ? bits : bytes;
      write("seg.dcm", dicom_seg(stored, type, single_bits ? bytes : bits));
      ASSERT_TRUE(recode_seg(path, syntax, egg_, bytes, sample));
      if (single_bits) patch_file(path, element(0x28, 0x100, "US", us(8)), element(0x28, 0x100, "US", us(1)));
      try {
        expect_same(import_label("Rest"), rest, "a segment");
        if (type != "LABELMAP") expect_same(import_label("Scapula"), scapula, "one that overlaps");
      } catch (const InputError& error) {
        ADD_FAILURE() << error.what();
      }
    }
  }
}

TEST_F(DicomFramesTest, DamagedCompressedSegmentationsAreRefused) {
  const std::string path = folder_.file("seg.dcm"),
                    whole = dicom_seg({{.label = "Scapula", .mask = mask()}}, "LABELMAP");
  for (const auto syntax : {gdcm::TransferSyntax::RLELossless, gdcm::TransferSyntax::JPEG2000Lossless}) {
    write("seg.dcm", whole);
    ASSERT_TRUE(recode_seg(path, syntax, egg_, 8, 8));
    fs::resize_file(path, fs::file_size(path) - 400);
    EXPECT_THAT(label_error("1"), HasSubstr("seg.dcm"));
  }
  // Compressed frames of another size than the header's.
  write("seg.dcm", whole);
  ASSERT_TRUE(recode_seg(path, gdcm::TransferSyntax::RLELossless, egg_, 8, 8));
  patch_file(path, element(0x28, 0x10, "US", us(30)), element(0x28, 0x10, "US", us(60)));
  EXPECT_THAT(label_error("1"), AllOf(HasSubstr("RLE (1.2.840.10008.1.2.5)"), HasSubstr("Explicit VR Little Endian")));
  using Syntax = gdcm::TransferSyntax;
  for (const Syntax::TSType syntax :
       {Syntax::JPEGLSLossless, Syntax::JPEG2000Lossless, Syntax::JPEGLosslessProcess14_1}) {
    write("seg.dcm", whole);
    ASSERT_TRUE(recode_seg(path, syntax, egg_, 8, 8));
    patch_file(path, element(0x28, 0x10, "US", us(30)), element(0x28, 0x10, "US", us(60)));
    EXPECT_THAT(label_error("1"), HasSubstr("a frame is compressed with 26x30 pixels, and the header says 26x60"));
  }
  patch_file(path, "\xe0\x7f\x10" + std::string(1, '\0'), "\xe0\x7f\x12" + std::string(1, '\0'));
  EXPECT_THAT(label_error("1"), HasSubstr("seg.dcm")) << "without pixels";
  const std::string sop_class = "1.2.840.10008.5.1.4.1.1.66.4";
  write("seg.dcm", dicom_file(sop_class, "1.2.3", element(8, 0x16, "UI", sop_class), "1.2.840.10008.1.2.4.201"));
  EXPECT_THAT(label_error("1"), AllOf(HasSubstr("HTJ2K (1.2.840.10008.1.2.4.201)"), HasSubstr("pydicom")));
  write("cd/1.dcm", "no DICOM");
  fs::rename(path, folder_.file("cd/2.dcm"));
  fs::rename(folder_.file("cd"), path);
  EXPECT_THAT(label_error("1"), AllOf(HasSubstr("2.dcm"), HasSubstr("HTJ2K (1.2.840.10008.1.2.4.201)")));
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
