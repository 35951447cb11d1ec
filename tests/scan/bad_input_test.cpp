// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

#include "sim/base/error.h"
#include "sim/scan/ct_import.h"
#include "test_images.h"

namespace reamsim::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

class BadCt : public ::testing::Test {
 protected:
  /// The message of the InputError; one line, with nothing printed beside it.
  std::string error_of(const BoneSettings& settings) {
    ::testing::internal::CaptureStderr();
    ::testing::internal::CaptureStdout();
    std::string message;
    try {
      Diagnostics report;
      voxmap_from_ct(settings, report);
      ADD_FAILURE() << "no error for " << settings.ct.path;
    } catch (const InputError& error) {
      message = error.what();
    } catch (const std::exception& error) {
      ADD_FAILURE() << "another exception: " << error.what();
    }
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
    EXPECT_THAT(message, Not(HasSubstr("\n")));
    EXPECT_THAT(message, Not(HasSubstr("itk")));
    return message;
  }
  std::string error_of(const std::string& path) { return error_of(settings_for(path, 1)); }

  std::string put(const std::string& name, const std::string& bytes) {
    std::ofstream(folder_.file(name), std::ios::binary) << bytes;
    return folder_.file(name);
  }
  static std::string bytes_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  TempFolder folder_;
};

TEST_F(BadCt, NoSuchFile) {
  EXPECT_THAT(error_of(folder_.file("absent.nrrd")), HasSubstr("absent.nrrd: bone.ct.path: no such file"));
}

TEST_F(BadCt, EmptyFile) {
  EXPECT_THAT(error_of(put("empty.nrrd", "")), HasSubstr("the file is empty"));
}

TEST_F(BadCt, PipeIsRefusedNotWaitedFor) {
  ASSERT_EQ(mkfifo(folder_.file("pipe.nrrd").c_str(), 0600), 0);
  EXPECT_THAT(error_of(folder_.file("pipe.nrrd")), HasSubstr("neither a file nor a folder"));
}

TEST_F(BadCt, SomethingElse) {
  EXPECT_THAT(error_of(put("notes.txt", "no image at all\n")), HasSubstr("not a readable CT image"));
  EXPECT_THAT(error_of(put("fake.nrrd", "no image at all\n")), HasSubstr("NRRD header is truncated or damaged"));
  EXPECT_THAT(error_of(put("fake.nii", std::string(400, 'x'))), HasSubstr("NIfTI header is truncated or damaged"));
}

TEST_F(BadCt, FolderWithoutDicom) {
  fs::create_directory(folder_.file("empty"));
  EXPECT_THAT(error_of(folder_.file("empty")), HasSubstr("no DICOM image found in this folder"));
  fs::create_directory(folder_.file("text"));
  put("text/readme.txt", "hello");
  EXPECT_THAT(error_of(folder_.file("text")), HasSubstr("no DICOM image found in this folder"));
}

TEST_F(BadCt, UnreadableFile) {
  const std::string path = put("secret.nrrd", "NRRD0004\n"), loop = folder_.file("loop.nrrd");
  fs::permissions(path, fs::perms::none);
  if (::geteuid() != 0) {
    EXPECT_THAT(error_of(path), HasSubstr("secret.nrrd"));
  }
  fs::create_symlink(loop, loop);  // which not even root can read
  EXPECT_THAT(error_of(loop), HasSubstr("loop.nrrd"));
}

TEST_F(BadCt, TruncatedFilesOfEveryFormat) {
  for (const std::string name : {"a.nrrd", "z.nrrd", "a.nii", "a.nii.gz", "a.mha", "z.mha"}) {
    const std::string whole = folder_.file("whole_" + name);
    write_image<std::int16_t>(egg_image(), whole, name[0] == 'z');
    const std::string bytes = bytes_of(whole);
    for (const double share : {0.02, 0.1, 0.3, 0.5, 0.9, 0.98}) {
      const auto length = static_cast<std::size_t>(share * static_cast<double>(bytes.size()));
      const std::string message = error_of(put(name, bytes.substr(0, length)));
      EXPECT_THAT(message, HasSubstr(name)) << share;
      EXPECT_THAT(message, HasSubstr("bone.ct.path")) << share;
    }
  }
}

TEST_F(BadCt, DetachedDataMissingOrShort) {
  write_image<std::int16_t>(egg_image(), folder_.file("a.mhd"));
  write_image<std::int16_t>(egg_image(), folder_.file("b.nhdr"));
  for (const auto& [header, data] : {std::pair{"a.mhd", "a.raw"}, std::pair{"b.nhdr", "b.raw"}}) {
    fs::resize_file(folder_.file(data), 1000);
    EXPECT_THAT(error_of(folder_.file(header)), HasSubstr("truncated")) << header;
    fs::remove(folder_.file(data));
    EXPECT_THAT(error_of(folder_.file(header)), HasSubstr(header)) << header;
  }
}

TEST_F(BadCt, TruncatedDicomSlice) {
  write_dicom(egg_image(), folder_.file("series"));
  const std::string slice = folder_.file("series/slice010.dcm");
  fs::resize_file(slice, fs::file_size(slice) / 2);
  EXPECT_THAT(error_of(folder_.file("series")), HasSubstr("series"));
}

TEST_F(BadCt, MissingDicomSlice) {
  write_dicom(egg_image(), folder_.file("series"), 9);
  EXPECT_THAT(error_of(folder_.file("series")), HasSubstr("slice spacing is 2.500 mm"));
}

TEST_F(BadCt, SingleDicomSlice) {
  TestImage image = egg_image();
  image.dims.z() = 1;
  image.sample(knobbed_egg);
  write_dicom(image, folder_.file("series"));
  EXPECT_THAT(error_of(folder_.file("series")), HasSubstr("one DICOM slice"));
}

TEST_F(BadCt, HeaderThatClaimsATrillionVoxels) {
  const std::string nrrd = put("huge.nrrd",
                               "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\n"
                               "sizes: 10000 10000 10000\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
                               "kinds: domain domain domain\nendian: little\nencoding: raw\n"
                               "space origin: (0,0,0)\n\nabc");
  EXPECT_THAT(error_of(nrrd), HasSubstr("1e+12 voxels"));
  const std::string mha = put("huge.mha",
                              "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                              "DimSize = 10000 10000 10000\nElementSpacing = 1 1 1\nElementType = MET_SHORT\n"
                              "ElementDataFile = LOCAL\nabc");
  EXPECT_THAT(error_of(mha), HasSubstr("1e+12 voxels"));
  write_image<std::int16_t>(egg_image(), folder_.file("huge.nii"));
  std::string nii = bytes_of(folder_.file("huge.nii"));
  for (int axis = 0; axis < 3; ++axis) {  // dim[1..3], int16 at bytes 42, 44, 46 of the NIfTI-1 header
    nii[42 + 2 * axis] = static_cast<char>(10000 & 255);
    nii[43 + 2 * axis] = static_cast<char>(10000 >> 8);
  }
  EXPECT_THAT(error_of(put("huge.nii", nii)), HasSubstr("1e+12 voxels"));
}

TEST_F(BadCt, HeaderThatClaimsMoreThanTheFileHolds) {
  const std::string nrrd = put("long.nrrd",
                               "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\n"
                               "sizes: 900 900 900\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
                               "kinds: domain domain domain\nendian: little\nencoding: raw\n"
                               "space origin: (0,0,0)\n\nabc");
  EXPECT_THAT(error_of(nrrd), HasSubstr("the header claims 729000000 voxels, but the file has only"));
}

TEST_F(BadCt, NotAVolumeOfNumbers) {
  const std::string flat = put("flat.mha",
                               "ObjectType = Image\nNDims = 2\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                               "DimSize = 2 2\nElementSpacing = 1 1\nElementType = MET_UCHAR\n"
                               "ElementDataFile = LOCAL\nabcd");
  EXPECT_THAT(error_of(flat), HasSubstr("expected a volume"));
  const std::string colour = put("rgb.mha",
                                 "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                                 "DimSize = 2 2 2\nElementSpacing = 1 1 1\nElementNumberOfChannels = 3\n"
                                 "ElementType = MET_UCHAR\nElementDataFile = LOCAL\nabcdefghijklmnopqrstuvwx");
  EXPECT_THAT(error_of(colour), HasSubstr("3 numbers in each voxel"));
}

TEST_F(BadCt, AbsurdSpacing) {
  for (const std::string directions :
       {"(0,0,0) (0,1,0) (0,0,1)", "(nan,0,0) (0,1,0) (0,0,1)", "(1,0,0) (1,0,0) (0,0,1)"}) {
    const std::string path =
        put("spacing.nrrd",
            "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\n"
            "space directions: " +
                directions + "\nkinds: domain domain domain\nencoding: raw\nspace origin: (0,0,0)\n\nabcdefgh");
    EXPECT_THAT(error_of(path), HasSubstr("spacing.nrrd"));
  }
}

class BadSegmentation : public BadCt {
 protected:
  void SetUp() override {
    write_image<std::int16_t>(egg_image(), folder_.file("egg.nrrd"));
    settings_ = settings_for(folder_.file("egg.nrrd"), 1);
  }
  BoneSettings settings_;
};

TEST_F(BadSegmentation, NothingAboveTheThreshold) {
  settings_.ct.threshold_hu = 300;
  const std::string message = error_of(settings_);
  EXPECT_THAT(message, HasSubstr("bone.ct.threshold_hu: no bone in the crop"));
  EXPECT_THAT(message, HasSubstr("250 HU"));
}

TEST_F(BadSegmentation, BoneAbsentFromTheCrop) {
  settings_.ct.crop_max_mm = Vec3(-29.5, 100, 200);
  EXPECT_THAT(error_of(settings_), HasSubstr("no bone in the crop"));
}

TEST_F(BadSegmentation, CropBesideTheImage) {
  settings_.ct.crop_min_mm = Vec3(500, 500, 500);
  const std::string message = error_of(settings_);
  EXPECT_THAT(message, HasSubstr("the crop contains no voxel of the image"));
  EXPECT_THAT(message, HasSubstr("(-33.0, 19.8, 95.4)"));
  settings_.ct.crop_min_mm = Vec3(-20, 30, 105);
  settings_.ct.crop_max_mm = Vec3(-25, 40, 110);
  EXPECT_THAT(error_of(settings_), HasSubstr("the crop contains no voxel of the image"));
}

TEST_F(BadSegmentation, SeedOutsideBone) {
  settings_.ct.seed_mm = Vec3(-32, 21, 97);
  EXPECT_THAT(error_of(settings_), HasSubstr("bone.ct.seed_mm: (-32.0, 21.0, 97.0) lies outside bone: 0 HU there"));
}

TEST_F(BadSegmentation, SeedOutsideTheImage) {
  settings_.ct.seed_mm = Vec3(0, 0, 0);
  EXPECT_THAT(error_of(settings_), HasSubstr("lies outside the image or crop"));
}

TEST_F(BadSegmentation, CutsThatLeaveNothing) {
  settings_.ct.cut_spheres.push_back({Vec3(-20, 35, 110), 50});
  EXPECT_THAT(error_of(settings_), HasSubstr("the cuts remove all bone"));
}

TEST_F(BadSegmentation, VoxelsOfAnAbsurdSize) {
  settings_.voxel_mm = 1e-4;
  EXPECT_THAT(error_of(settings_), HasSubstr("bone.voxel_mm"));
  settings_.voxel_mm = 1e-12;
  EXPECT_THAT(error_of(settings_), HasSubstr("bone.voxel_mm"));
  settings_.voxel_mm = 500;
  EXPECT_THAT(error_of(settings_), HasSubstr("no bone remains at this voxel size"));
}

TEST_F(BadSegmentation, LabelThatTheMapDoesNotHold) {
  write_image<std::uint8_t>(egg_image(), folder_.file("labels.nrrd"));
  settings_.ct.label_map = LabelMapSettings{.path = folder_.file("labels.nrrd"), .label = {"7"}};
  EXPECT_THAT(error_of(settings_), HasSubstr("no voxel in the crop has label 7; the map holds 100, 250 there"));
  settings_.ct.label_map->path = folder_.file("absent.nrrd");
  EXPECT_THAT(error_of(settings_), HasSubstr("absent.nrrd: bone.ct.label_map.path: no such file"));
}

TEST_F(BadCt, DamagedDicomNeverCrashes) {
  // Bytes on which GDCM's assertions fail: an element that ends with the file, and one with no such type.
  write_dicom(egg_image(), folder_.file("series"));
  const std::string bytes = bytes_of(folder_.file("series/slice010.dcm"));
  for (const std::size_t length : {140U, 150U, 200U, 330U}) {
    put("series/slice010.dcm", bytes.substr(0, length));
    EXPECT_THAT(error_of(folder_.file("series")), HasSubstr("series")) << length;
    EXPECT_THAT(error_of(put("single.dcm", bytes.substr(0, length))), HasSubstr("single.dcm")) << length;
  }
  std::string damaged = bytes;
  damaged.replace(148, 2, "\xff\xfe");  // the type of an element in the first group
  put("series/slice010.dcm", damaged);
  EXPECT_THAT(error_of(folder_.file("series")), HasSubstr("series"));
}

TEST_F(BadCt, DamagedHeadersNeverCrash) {
  constexpr unsigned kSeed = 7;
  unsigned state = kSeed;
  const auto random = [&](std::size_t below) {
    state = state * 1664525U + 1013904223U;
    return static_cast<std::size_t>(state >> 8) % below;
  };
  int failed = 0;
  for (const std::string name : {"f.nrrd", "f.nii", "f.mha"}) {
    write_image<std::int16_t>(egg_image(), folder_.file("whole_" + name));
    const std::string bytes = bytes_of(folder_.file("whole_" + name));
    for (int trial = 0; trial < 60; ++trial) {
      std::string damaged = bytes;
      for (int hit = 0; hit < 3; ++hit) damaged[random(348)] = static_cast<char>(random(256));
      try {
        Diagnostics report;
        voxmap_from_ct(settings_for(put(name, damaged), 1), report);
      } catch (const InputError& error) {
        EXPECT_THAT(std::string(error.what()), Not(HasSubstr("\n"))) << "seed " << kSeed << " trial " << trial;
        ++failed;
      }
    }
  }
  EXPECT_GT(failed, 20) << "seed " << kSeed;
}

}  // namespace
}  // namespace reamsim::test
