// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "dicom_bytes.h"
#include "dicom_fixture.h"
#include "sim/scan/scan.h"

namespace reamsim::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST_F(Dicom, SubfoldersAndFilesWithoutExtensionAreFound) {
  write_dicom(egg_, folder_.file("cd/PA000001/ST000001/SE000001"), -1, {.ending = ""});
  write("cd/DICOMDIR", std::string(128, '\0') + "DICM");
  write("cd/autorun.inf", "[autorun]");
  expect_egg("cd");
  expect_egg("cd/DICOMDIR");
}

TEST_F(Dicom, FilesThatAreNoSlicesDoNotStopASeries) {
  write_dicom(egg_, folder_.file("cd/a"));
  write("cd/report.pdf", "%PDF-1.4 ...");
  write("cd/readme", "no image");
  write("cd/empty", "");
  write("cd/damaged", std::string(128, '\0') + "DICM" + std::string("\x02\0\0\0UL\x04\0\xff\xff", 10));
  // A structured report: a DICOM file without pixels.
  write_dicom(cropped(egg_, {0, 0, 0}, {26, 30, 1}), folder_.file("sr"));
  patch_file(folder_.file("sr/slice001.dcm"), std::string("\x28\0\x10\0", 4), std::string("\x28\0\x0f\0", 4));
  fs::copy(folder_.file("sr/slice001.dcm"), folder_.file("cd/report.dcm"));
  expect_egg("cd");
}

TEST_F(Dicom, SeriesAreListedAndTheLargestCtIsTaken) {
  write_dicom(egg_, folder_.file("cd/a"), -1,
              {.series = "1.2.7", .number = 3, .description = "Bone", .kernel = "B60s"});
  write_dicom(cropped(other(), {0, 0, 0}, {26, 30, 20}), folder_.file("cd/b"), -1,
              {.series = "1.2.8", .number = 2, .description = "Soft", .kernel = "B30f"});
  write_dicom(egg_, folder_.file("cd/c"), -1, {.series = "1.2.9", .number = 9, .modality = "PT"});
  expect_egg("cd");
  ASSERT_EQ(report_.warnings.size(), 1U);
  EXPECT_THAT(report_.warnings[0], HasSubstr("3 DICOM series; using the one with the most slices (24 slices)"));
  ASSERT_EQ(report_.listings.size(), 1U);
  EXPECT_THAT(report_.listings[0],
              AllOf(HasSubstr("the one in use is 1.2.7"),
                    HasSubstr("1: UID 1.2.8, \"Soft\", CT, 20 slices of 26x30, 1x1x1.25 mm, kernel B30f; 2: UID 1.2.7"),
                    HasSubstr("3: UID 1.2.9, \"\", PT, 24 slices")));
}

TEST_F(Dicom, ASeriesIsChosenByUidOrNumber) {
  write_dicom(egg_, folder_.file("cd/a"), -1, {.series = "1.2.8", .number = 2});
  write_dicom(other(), folder_.file("cd/b"), -1, {.series = "1.2.7", .number = 3});
  write_image<std::int16_t>(other(), folder_.file("other.nrrd"));
  series_ = "";
  EXPECT_THAT(error_of("cd"), AllOf(HasSubstr("bone.ct.series: missing, and two DICOM series have 24 slices"),
                                    HasSubstr("1: UID 1.2.8"), HasSubstr("2: UID 1.2.7")));
  series_ = "1";
  expect_egg("cd");
  series_ = "1.2.8";
  expect_egg("cd");
  series_ = "1.2.7";
  const FilledVoxmap by_uid = import("cd");
  series_ = "2";
  expect_same(import("cd"), by_uid, "2");
  EXPECT_GT((by_uid.grid.origin_mm - reference_.grid.origin_mm).norm(), 1.5) << "the displaced egg";
  for (const std::string wrong : {"0", "3", "1.2.9", "999999999"}) {
    series_ = wrong;
    EXPECT_THAT(error_of("cd"),
                AllOf(HasSubstr("bone.ct.series: no DICOM series '" + wrong + "'"), HasSubstr("1 to 2: 1: UID 1.2.8")));
  }
  series_ = "1";
  EXPECT_THAT(error_of("other.nrrd"), HasSubstr("bone.ct.series: given for a file that is not a DICOM folder"));
}

TEST_F(Dicom, OfAsManySlicesTheFinerOnesAreTaken) {
  write_dicom(egg_, folder_.file("cd/a"), -1, {.series = "1.2.8"});
  TestImage coarse = egg_;
  coarse.spacing_mm = {1, 1, 2};
  coarse.sample(knobbed_egg);
  write_dicom(coarse, folder_.file("cd/b"), -1, {.series = "1.2.7"});
  expect_egg("cd");
  EXPECT_EQ(report_.warnings.size(), 1U);
}

TEST_F(Dicom, AnotherModalityIsRefusedUnlessAskedFor) {
  write_dicom(egg_, folder_.file("mr"), -1, {.modality = "MR"});
  EXPECT_THAT(error_of("mr"),
              AllOf(HasSubstr("bone.ct.modality: the series is MR, not CT"), HasSubstr("bone.ct.modality: any")));
  series_ = "1";
  EXPECT_THAT(error_of("mr"), HasSubstr("the series is MR"));
  series_ = "";
  modality_ = Modality::any;
  expect_egg("mr");
  ASSERT_EQ(report_.warnings.size(), 1U);
  EXPECT_THAT(report_.warnings[0], HasSubstr("modality MR, not CT"));
  modality_ = Modality::ct;
  write_dicom(egg_, folder_.file("two/a"), -1, {.series = "1.2.8", .modality = "MR"});
  write_dicom(egg_, folder_.file("two/b"), -1, {.series = "1.2.7", .modality = "PT"});
  EXPECT_THAT(error_of("two"), HasSubstr("none of the 2 DICOM series is CT"));
}

TEST_F(Dicom, Monochrome1IsRefused) {
  write_dicom(egg_, folder_.file("cd"));
  for (const auto& file : fs::directory_iterator(folder_.file("cd"))) {
    patch_file(file.path().string(), "MONOCHROME2", "MONOCHROME1");
  }
  EXPECT_THAT(error_of("cd"), AllOf(HasSubstr("slice024.dcm"), HasSubstr("MONOCHROME1"), HasSubstr("inverted")));
}

TEST_F(Dicom, ASliceWithoutRescaleAmongOthersIsRefused) {
  write_dicom(egg_, folder_.file("scan"), -1, {.more = {{"0028|1052", "0"}, {"0028|1053", "1"}}});
  expect_egg("scan");
  const std::string slice = folder_.file("scan/slice005.dcm");
  patch_file(slice, std::string("\x28\x00\x52\x10", 4), std::string("\x28\x00\x50\x10", 4));  // now a window
  patch_file(slice, std::string("\x28\x00\x53\x10", 4), std::string("\x28\x00\x51\x10", 4));
  EXPECT_THAT(error_of("scan"), AllOf(HasSubstr("slice005.dcm"), HasSubstr("no rescale intercept and slope")));
}

TEST_F(Dicom, ATubeVoltageThatTheDensityDoesNotHoldForIsWarnedOf) {
  const std::pair<const char*, bool> voltages[] = {{"80", true}, {"140", true}, {"120", false}, {"110", false}};
  for (const auto& [kvp, warns] : voltages) {
    const std::string name = std::string("at") + kvp;
    write_dicom(egg_, folder_.file(name), -1, {.more = {{"0018|0060", kvp}}});
    report_ = {};
    expect_egg(name);
    EXPECT_EQ(
        testing::Matches(testing::Contains(HasSubstr(std::string("scanned at ") + kvp + " kV")))(report_.warnings),
        warns)
        << kvp;
  }
  BoneSettings calibrated = settings("at80");
  calibrated.density.ash_slope_g_cm3_per_hu = 0.0006;
  report_ = {};
  voxmap_from_ct(calibrated, report_);
  EXPECT_THAT(report_.warnings, testing::IsEmpty()) << "the constants are the user's";
}

TEST_F(Dicom, MessagesNameTheSlice) {
  write_dicom(egg_, folder_.file("gap"), 9);
  EXPECT_THAT(error_of("gap"), AllOf(HasSubstr("slice spacing is 2.500 mm; most slices are 1.250 mm apart"),
                                     HasSubstr("slice016.dcm and "), HasSubstr("slice014.dcm"),
                                     HasSubstr("a slice is missing between them")));
  write_dicom(egg_, folder_.file("size"), 9);
  TestImage small = cropped(egg_, {0, 0, 9}, {26, 20, 1});
  write_dicom(small, folder_.file("one"));
  fs::copy(folder_.file("one/slice001.dcm"), folder_.file("size/odd.dcm"));
  EXPECT_THAT(error_of("size"), HasSubstr("odd.dcm lies there and has 26x20 pixels; the other slices have 26x30"));
  write_dicom(egg_, folder_.file("turn"), 9);
  TestImage turned = cropped(egg_, {0, 0, 9}, {26, 30, 1});
  turned.direction.col(0) = Vec3(0.98, 0.199, 0).normalized();
  turned.direction.col(1) = Vec3::UnitZ().cross(turned.direction.col(0));
  fs::remove_all(folder_.file("one"));
  write_dicom(turned, folder_.file("one"));
  fs::copy(folder_.file("one/slice001.dcm"), folder_.file("turn/odd.dcm"));
  EXPECT_THAT(error_of("turn"),
              HasSubstr("odd.dcm lies there and has an orientation different from that of the other slices"));
}

TEST_F(Dicom, ADamagedSliceIsNamedWhereItIsMissing) {
  write_dicom(egg_, folder_.file("cd"));
  fs::resize_file(folder_.file("cd/slice010.dcm"), 150);
  EXPECT_THAT(error_of("cd"),
              AllOf(HasSubstr("slice011.dcm and "), HasSubstr("slice009.dcm"), HasSubstr("slice010.dcm was skipped")));
  write_dicom(egg_, folder_.file("half"));
  const std::string slice = folder_.file("half/slice010.dcm");
  fs::resize_file(slice, fs::file_size(slice) / 2);
  EXPECT_THAT(error_of("half"), HasSubstr("slice010.dcm"));
}

TEST_F(Dicom, ADamagedSliceAtAnEndIsNamed) {
  const auto damages = {"cut", "emptied", "overwritten", "no rows"};
  for (const std::string slice : {"slice001.dcm", "slice024.dcm"}) {
    for (const std::string how : damages) {
      SCOPED_TRACE(slice + " " + how);
      fs::remove_all(folder_.file("cd"));
      write_dicom(egg_, folder_.file("cd"));
      const std::string path = folder_.file("cd/" + slice);
      if (how == "cut") fs::resize_file(path, 150);
      if (how == "emptied") fs::resize_file(path, 0);
      if (how == "overwritten") write("cd/" + slice, std::string(5000, 'x'));
      if (how == "no rows") patch_file(path, std::string("\x28\0\x10\0", 4), std::string("\x28\0\x0f\0", 4));
      EXPECT_THAT(error_of("cd"), AllOf(HasSubstr(slice + ": bone.ct.path: cannot be read as a DICOM slice"),
                                        HasSubstr("move it out of the folder")));
    }
  }
}

TEST_F(Dicom, AnOverwrittenSliceInTheMiddleIsNamed) {
  write_dicom(egg_, folder_.file("cd"));
  write("cd/slice010.dcm", std::string(5000, 'x'));
  EXPECT_THAT(error_of("cd"),
              AllOf(HasSubstr("a slice is missing between them"), HasSubstr("slice010.dcm was skipped")));
}

TEST_F(Dicom, PicturesInASeriesAreLeftOut) {
  // A dose report with the series' own UID: an image without a place.
  write_dicom(egg_, folder_.file("cd"));
  write_dicom(cropped(egg_, {0, 0, 0}, {26, 30, 1}), folder_.file("one"));
  const std::string picture = folder_.file("cd/dose_report.dcm");
  fs::copy(folder_.file("one/slice001.dcm"), picture);
  patch_file(picture, std::string("\x20\0\x32\0", 4), std::string("\x20\0\x31\0", 4));
  expect_egg("cd");
  ASSERT_EQ(report_.warnings.size(), 1U);
  EXPECT_THAT(report_.warnings[0],
              AllOf(HasSubstr("images of the DICOM series skipped because they are not slices: 1, the first is "),
                    HasSubstr("dose_report.dcm, which has no valid position (0020,0032)")));
}

TEST_F(Dicom, OddGeometryAndRescaleOfSlices) {
  // A slice thickness is not used where positions say more.
  write_slices(egg_, folder_.file("thin"), {.more = {{0x00180050, element(0x18, 0x50, "DS", "0.0005")}}});
  expect_egg("thin");
  ASSERT_EQ(report_.warnings.size(), 0U);
  ASSERT_EQ(egg_.spacing_mm.head<2>(), Vec2::Ones());
  const auto expect_assumed = [&](const std::string& name, unsigned number, const std::string& text,
                                  const std::string& words) {
    write_slices(egg_, folder_.file(name), {.more = {{0x00280000 + number, element(0x28, number, "DS", text)}}});
    expect_egg(name);
    ASSERT_EQ(report_.warnings.size(), 1U) << name;
    EXPECT_THAT(report_.warnings[0], HasSubstr(words + "; so in 24 of 24 slices"));
  };
  expect_assumed("square", 0x30, "1", "the pixel spacing (0028,0030) is one number, taken for rows and columns");
  expect_assumed("no_slope", 0x1053, "0", "the rescale slope (0028,1053) is 0; 1 is taken");
  // An image without geometry beside the slices is skipped; a series of such images is refused.
  write_slices(egg_, folder_.file("cd"));
  const TestImage one = cropped(egg_, {0, 0, 0}, {26, 30, 1});
  write_slices(one, folder_.file("cd/scout"), {.more = {{0x00280030, element(0x28, 0x30, "DS", "0\\0")}}});
  expect_egg("cd");
  ASSERT_EQ(report_.warnings.size(), 1U);
  EXPECT_THAT(report_.warnings[0], HasSubstr("which has no valid pixel spacing (0028,0030)"));
  write_slices(egg_, folder_.file("none"), {.more = {{0x00200037, element(0x20, 0x37, "DS", "0\\0\\0\\0\\0\\0")}}});
  EXPECT_THAT(error_of("none"), HasSubstr("an image without a valid orientation (0020,0037)"));
}

TEST_F(Dicom, SlicesInOnePlace) {
  write_dicom(egg_, folder_.file("cd"));
  fs::copy(folder_.file("cd/slice010.dcm"), folder_.file("cd/copy_of_10.dcm"));
  expect_egg("cd");
  ASSERT_EQ(report_.warnings.size(), 1U);
  EXPECT_THAT(report_.warnings[0], HasSubstr("copies of DICOM slices skipped: 1"));
  write_dicom(other(), folder_.file("again"));
  fs::copy(folder_.file("again/slice010.dcm"), folder_.file("cd/phase_2.dcm"));
  fs::remove(folder_.file("cd/copy_of_10.dcm"));
  fs::create_directory(folder_.file("twice"));
  fs::copy(folder_.file("cd/slice010.dcm"), folder_.file("twice/a"));
  fs::copy(folder_.file("cd/slice010.dcm"), folder_.file("twice/b"));
  EXPECT_THAT(error_of("twice"), HasSubstr("one DICOM slice"));
  EXPECT_THAT(error_of("cd"),
              AllOf(HasSubstr("phase_2.dcm"), HasSubstr("has the same position as"), HasSubstr("slice010.dcm")));
}

/// A multi-frame file of `frames` frames of 4×4 pixels that does not say where they lie.
std::string frames_without_place(int frames) {
  const std::string storage = "1.2.840.10008.5.1.4.1.1.2.1";
  std::string out;
  out += element(8, 0x16, "UI", storage) + element(8, 0x18, "UI", "1.2.3.9") + element(8, 0x60, "CS", "CT");
  out += element(0x20, 0xd, "UI", "1.2.3") + element(0x20, 0xe, "UI", "1.2.3.4");
  out += element(0x28, 2, "US", us(1)) + element(0x28, 4, "CS", "MONOCHROME2") +
         element(0x28, 8, "IS", std::to_string(frames)) + element(0x28, 0x10, "US", us(4)) +
         element(0x28, 0x11, "US", us(4)) + element(0x28, 0x100, "US", us(16)) + element(0x28, 0x101, "US", us(16)) +
         element(0x28, 0x102, "US", us(15)) + element(0x28, 0x103, "US", us(1));
  out += element(0x7fe0, 0x10, "OW", std::string(static_cast<std::size_t>(frames) * 32, '\1'));
  return dicom_file(storage, "1.2.3.9", out);
}

TEST_F(Dicom, FramesWithoutAPlaceAreRefused) {
  fs::create_directory(folder_.file("cd"));
  write("cd/IM0001", frames_without_place(30));
  const auto refusal = AllOf(HasSubstr("IM0001"), HasSubstr("a multi-frame DICOM file (30 frames) without functional"),
                             HasSubstr("convert it to NRRD or NIfTI (3D Slicer, dcm2niix), or export single slices"));
  EXPECT_THAT(error_of("cd"), refusal);
  EXPECT_THAT(error_of("cd/IM0001"), refusal);
  // It is not silently replaced by a smaller series.
  write_dicom(egg_, folder_.file("cd/slices"), -1, {.series = "1.2.8"});
  EXPECT_THAT(error_of("cd"), refusal);
  series_ = "1.2.8";
  expect_egg("cd");
}

TEST_F(Dicom, ASingleFileIsNoVolume) {
  write_dicom(egg_, folder_.file("cd"));
  EXPECT_THAT(error_of("cd/slice010.dcm"), HasSubstr("a single DICOM slice; give the folder of the series"));
}

TEST_F(Dicom, PrivateSyntaxOfGeHasPixelsInTheOtherByteOrder) {
  write_slices(egg_, folder_.file("ge"), {.ge_private = true});
  expect_egg("ge");
}

// 100 orientations, of which half have a tilted gantry. Slices are sorted along the normal.
TEST_F(Dicom, RandomOrientationsAreTakenAsTheyStand) {
  std::mt19937 random(20261130);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> tilt(-0.4, 0.4);
  for (int run = 0; run < 100; ++run) {
    TestImage image{.dims = {4, 3, 5}, .spacing_mm = {0.5, 0.7, 1.1}, .value = std::vector<double>(60, 100)};
    image.direction = Quat(normal(random), normal(random), normal(random), normal(random)).normalized().matrix();
    if (run % 2 == 1) image.direction.col(2) += tilt(random) * image.direction.col(1);
    if (random() % 2 == 0) image.direction.col(2) *= -1;
    image.origin_mm = 100 * Vec3(normal(random), normal(random), normal(random));
    const std::string name = "series" + std::to_string(run);
    write_slices(image, folder_.file(name), {.decimals = 9});
    Mat3 steps = image.direction * image.spacing_mm.asDiagonal();
    Vec3 origin = image.origin_mm;
    if (steps.determinant() < 0) {
      origin = image.point_mm(0, 0, image.dims.z() - 1);
      steps.col(2) *= -1;
    }
    CtSettings settings;
    settings.path = folder_.file(name);
    const ct::ScanGeometry found = ct::open_scan(settings, report_).geometry;
    EXPECT_LT((found.step_mm - steps).norm(), 1e-6) << name;
    EXPECT_LT((found.origin_mm - origin).norm(), 1e-6) << name;
  }
}

}  // namespace
}  // namespace reamsim::test
