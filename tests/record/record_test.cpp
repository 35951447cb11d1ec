// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <filesystem>
#include <limits>

#include "sim/base/checksum.h"
#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/record/output_folder.h"
#include "sim/record/recorder.h"
#include "sim/record/summary.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

namespace fs = std::filesystem;

TEST(CsvWriter, NumbersReadBackToTheSameValue) {
  const TempDir dir;
  const std::string path = dir.path() + "/a.csv";
  CsvWriter log(path, "x,y,z");
  log.row({0.1, 1.0 / 3, -0.0});
  log.row({1e-300, 123456789, 2});
  log.row({std::numeric_limits<double>::quiet_NaN(), 1, std::numeric_limits<double>::quiet_NaN()});
  log.close();
  EXPECT_EQ(file_bytes(path), "x,y,z\n0.1,0.3333333333333333,0\n1e-300,123456789,2\n,1,\n");
}

TEST(CsvWriter, IntegersHaveNoExponent) {
  const TempDir dir;
  const std::string path = dir.path() + "/a.csv";
  CsvWriter log(path, "x,y,z");
  log.row({100000, 1e7, -3e15});
  log.row({9007199254740992.0, 1e300, 100000.5});
  log.close();
  EXPECT_EQ(file_bytes(path), "x,y,z\n100000,10000000,-3000000000000000\n9007199254740992,1e+300,100000.5\n");
}

TEST(CsvWriter, AFullDiskIsARunError) {
  EXPECT_THROW(
      {
        CsvWriter log("/dev/full", "x");
        log.row({1});
        log.close();
      },
      RunError);
}

TEST(Checksum, OfAFileAndAFolder) {
  const TempDir dir;
  std::ofstream(dir.path() + "/b.dcm") << "abc";
  // FIPS 180-2, appendix B.1.
  EXPECT_EQ(sha256_of(dir.path() + "/b.dcm"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const std::string one = sha256_of(dir.path());
  std::ofstream(dir.path() + "/a.dcm") << "more";
  EXPECT_NE(sha256_of(dir.path()), one);
  const std::string flat = sha256_of(dir.path());
  std::filesystem::create_directory(dir.path() + "/sub");
  EXPECT_EQ(sha256_of(dir.path()), flat);
  std::ofstream(dir.path() + "/sub/c.dcm") << "deep";
  EXPECT_NE(sha256_of(dir.path()), flat) << "DICOM lies in subfolders as well";
  EXPECT_THROW(sha256_of(dir.path() + "/none"), InputError);
}

OutputRequest request(const std::string& dir, bool overwrite) {
  return {.dir = dir, .kind = ResultKind::run, .overwrite = overwrite, .inputs = {}};
}

TEST(OutputFolder, AppearsOnlyWhenFinished) {
  const TempDir dir;
  const std::string out = dir.path() + "/deep/run";
  {
    OutputFolder folder(request(out, false));
    std::ofstream(folder.path() + "/summary.json") << "1";
    EXPECT_FALSE(fs::exists(out));
    folder.finish();
  }
  EXPECT_TRUE(fs::exists(out + "/summary.json"));
  EXPECT_FALSE(fs::exists(out + ".partial"));
  EXPECT_THROW(OutputFolder(request(out, false)), InputError);
}

TEST(OutputFolder, LeavesNothingAfterAFailureAndTheOldOneInPlace) {
  const TempDir dir;
  const std::string out = dir.path() + "/run";
  fs::create_directory(out);
  std::ofstream(out + "/summary.json") << "old";
  {
    const OutputFolder folder(request(out, true));
    std::ofstream(folder.path() + "/forces.csv") << "1";
  }
  EXPECT_EQ(file_bytes(out + "/summary.json"), "old");
  EXPECT_FALSE(fs::exists(out + ".partial"));
  {
    OutputFolder folder(request(out + "/", true));
    std::ofstream(folder.path() + "/scenario.yaml") << "new";
    folder.finish();
  }
  EXPECT_FALSE(fs::exists(out + "/summary.json"));
  EXPECT_EQ(file_bytes(out + "/scenario.yaml"), "new");
  EXPECT_EQ(std::distance(fs::directory_iterator(dir.path()), fs::directory_iterator()), 1) << "nothing beside it";
}

TEST(OutputFolder, WhatIsNotOursIsNeverRemoved) {
  const TempDir dir;
  const std::string out = dir.path() + "/run";
  {
    const OutputFolder folder(request(out, false));
    std::ofstream(folder.path() + "/forces.csv") << "1";
    std::ofstream(folder.path() + "/thesis.tex") << "mine";
  }
  EXPECT_EQ(file_bytes(out + ".partial/thesis.tex"), "mine");
  EXPECT_FALSE(fs::exists(out + ".partial/forces.csv"));
}

TEST(OutputFolder, FinishedResultsStayWhereTheyCannotBePutInPlace) {
  const TempDir dir;
  const std::string out = dir.path() + "/run";
  const auto expect_kept = [&](bool overwrite, const std::string& found) {
    {
      OutputFolder folder(request(out, overwrite));
      std::ofstream(folder.path() + "/summary.json") << "done";
      fs::create_directory(out);  // meanwhile
      std::ofstream(out + "/thesis.tex") << "mine";
      try {
        folder.finish();
        FAIL() << "expected an error";
      } catch (const RunError& error) {
        EXPECT_THAT(error.what(), ::testing::HasSubstr(out + ".partial"));
        EXPECT_THAT(error.what(), ::testing::HasSubstr(found));
      }
    }
    EXPECT_EQ(file_bytes(out + ".partial/summary.json"), "done");
    EXPECT_EQ(file_bytes(out + "/thesis.tex"), "mine");
    fs::remove_all(out);
    fs::remove_all(out + ".partial");
  };
  expect_kept(false, "File exists");
  expect_kept(true, "thesis.tex");
}

TEST(OutputFolder, KeepsWhatWasInterrupted) {
  const TempDir dir;
  const std::string out = dir.path() + "/run";
  {
    OutputFolder folder(request(out, false));
    folder.keep();
  }
  EXPECT_TRUE(fs::exists(out + ".partial"));
  EXPECT_THROW(OutputFolder(request(out, false)), InputError);  // nothing is lost without being asked
  const OutputFolder again(request(out, true));
  EXPECT_TRUE(fs::exists(again.path()));
}

TEST(OutputFolder, OnlyOneRunAtATimeUsesAFolder) {
  const TempDir dir;
  const std::string out = dir.path() + "/run";
  {
    OutputFolder first(request(out, false));
    std::ofstream(first.path() + "/summary.json") << "first";
    for (const bool overwrite : {false, true}) {
      try {
        const OutputFolder second(request(out, overwrite));
        FAIL() << "expected an error";
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), ::testing::HasSubstr(out + ": output folder: is in use by reamsim process "));
      }
    }
    first.finish();
  }
  EXPECT_EQ(file_bytes(out + "/summary.json"), "first");
  EXPECT_FALSE(fs::exists(out + ".lock"));
  std::ofstream(out + ".lock") << "a file of the user";
  EXPECT_THROW(OutputFolder(request(out, true)), InputError);
  EXPECT_EQ(file_bytes(out + ".lock"), "a file of the user");
}

TEST(OutputFolder, FilesThatTheManifestDoesNotListAreForeign) {
  const TempDir dir;
  const std::string out = dir.path() + "/run";
  {
    OutputFolder folder(request(out, false));
    std::ofstream(folder.path() + "/summary.json") << "1";
    folder.finish();
  }
  std::ofstream(out + "/reamed_side.png") << "a picture of the user, with a name that render might use";
  EXPECT_THROW(OutputFolder(request(out, true)), InputError);
  {
    ResultUpdate update(out, ResultKind::run);
    std::ofstream(out + "/reamed_top.png") << "new";
    EXPECT_THROW(OutputFolder(request(out, true)), InputError) << "in use";
    update.finish();
  }
  try {
    const OutputFolder foreign(request(out, true));
    FAIL() << "expected an error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("holds reamed_side.png"));
  }
  fs::remove(out + "/reamed_side.png");
  OutputFolder again(request(out, true));
  again.finish();
  EXPECT_EQ(std::distance(fs::directory_iterator(out), fs::directory_iterator()), 1) << "the manifest alone";
}

TEST(OutputFolder, FoldersOfADamagedOrOlderManifestAreRecognizedByTheirNames) {
  const TempDir dir;
  const std::string out = dir.path() + "/run";
  fs::create_directory(out);
  std::ofstream(out + "/summary.json") << "1";
  for (const char* text : {"", "{", "[]", "{\"kind\": 7}", "{\"kind\": \"run\", \"files\": [1]}",
                           "{\"kind\": \"run\", \"files\": [], \"complete\": \"yes\"}"}) {
    std::ofstream(out + "/manifest.json") << text;
    EXPECT_THROW(OutputFolder(request(out, true)), InputError) << text;
  }
  fs::remove(out + "/manifest.json");
  OutputFolder(request(out, true)).finish();
  EXPECT_FALSE(fs::exists(out + "/summary.json"));
}

TEST(OutputFolder, ADamagedManifestDoesNotEndTheProgramThatRemovesAnUnfinishedFolder) {
  const TempDir dir;
  {
    const OutputFolder folder(request(dir.path() + "/run", false));
    std::ofstream(folder.path() + "/manifest.json") << "{\"kind\": \"run\", \"files\": [], \"complete\": 1}";
    std::ofstream(folder.path() + "/summary.json") << "1";
  }
  EXPECT_FALSE(fs::exists(dir.path() + "/run.partial/summary.json"));
}

TEST(OutputFolder, AFailureLeavesNoEmptyFoldersBehind) {
  const TempDir dir;
  { const OutputFolder folder(request(dir.path() + "/new/deep/run", false)); }
  EXPECT_FALSE(fs::exists(dir.path() + "/new"));
}

TEST(OutputFolder, AFileInTheWay) {
  const TempDir dir;
  std::ofstream(dir.path() + "/file") << "1";
  EXPECT_THROW(OutputFolder(request(dir.path() + "/file", false)), InputError);
  EXPECT_THROW(OutputFolder(request(dir.path() + "/file", true)), InputError);
  EXPECT_THROW(OutputFolder(request(dir.path() + "/file/below", false)), InputError);
  EXPECT_EQ(file_bytes(dir.path() + "/file"), "1");
}

TEST(RunTotals, SumsAndExtremes) {
  RunTotals totals(1);
  FrameResult a, b;
  a.frame = 3;
  a.contacts = 5;
  a.force_n = {3, 4, 0};
  a.axial_force_n = 2;
  a.removed_mm3 = 1.5;
  b.frame = 4;
  b.time_s = 0.004;
  b.contacts = 1;
  b.force_n = {0, 0, 1};
  b.removed_mm3 = 0.5;
  totals.add({});
  totals.add(a);
  totals.add(b);
  EXPECT_EQ(totals.frames, 3);
  EXPECT_EQ(totals.contact_frames, 2);
  EXPECT_EQ(totals.first_contact_frame, 3);
  EXPECT_DOUBLE_EQ(totals.removed_mm3, 2);
  EXPECT_DOUBLE_EQ(totals.peak_force_n, 5);
  EXPECT_DOUBLE_EQ(totals.rms_force_n(), std::sqrt(13.0));
  EXPECT_DOUBLE_EQ(totals.simulated_s, 0.004);
}

TEST(RunTotals, MeansAreOverTheReamingTime) {
  RunTotals totals(1);
  EXPECT_EQ(totals.reaming_frames(), 0);
  EXPECT_EQ(totals.means().force_n, 0);
  for (int k = 0; k < 10; ++k) {
    FrameResult row;
    row.frame = k;
    row.depth_mm = k < 7 ? 0.5 * k : 0;
    row.pose.position_mm.z() = -row.depth_mm;
    // Contact in rows 2, 3 and 5: the reaming time is four rows.
    if (k == 2 || k == 3 || k == 5) {
      row.contacts = 1;
      row.force_n = {3, 0, 4};
      row.torque_nmm = {0, 0, 8};
      row.axial_force_n = 4;
      row.spin_torque_nmm = -8;
      row.energy_mj = 2;
      row.floor_energy_mj = 0.5;
    }
    row.balance = k < 2 ? 0 : 0.25;
    totals.add(row);
  }
  EXPECT_EQ(totals.reaming_frames(), 4);
  EXPECT_DOUBLE_EQ(totals.means().force_n, 15.0 / 4);
  EXPECT_DOUBLE_EQ(totals.means().torque_nmm, 24.0 / 4);
  EXPECT_DOUBLE_EQ(totals.means().axial_force_n, 12.0 / 4);
  EXPECT_DOUBLE_EQ(totals.means().spin_torque_nmm, -24.0 / 4);
  // balance = (work + floor − cut)/cut, so work = 6·1.25 − 1.5.
  EXPECT_DOUBLE_EQ(totals.work_mj(), 6.0);
  EXPECT_DOUBLE_EQ(totals.deepest_pose.position_mm.z(), -3);
}

TEST(LayerMean, SpikesBecomeTheirMeanOverAVoxelOfTravel) {
  LayerMean mean(0.5);
  // 0.1 mm a frame: one spike of 50 N in five frames is 10 N on average.
  for (int k = 0; k < 30; ++k) {
    const double spike = k % 5 == 3 ? 50 : 0;
    const auto means = mean.add({0, 0, -0.1 * k}, spike, 2 * spike);
    if (k < 5) {
      EXPECT_EQ(means.axial_force_n, 0) << "frame " << k;
    } else {
      EXPECT_NEAR(means.axial_force_n, 10, 1e-12) << "frame " << k;
      EXPECT_NEAR(means.spin_torque_nmm, 20, 1e-12) << "frame " << k;
    }
  }
}

TEST(LayerMean, StandingStillForgetsFrameByFrame) {
  LayerMean mean(0.5);
  LayerMean::Means means;
  for (int k = 0; k < 20; ++k) means = mean.add({0, 0, -0.1 * k}, 10, 0);
  ASSERT_EQ(means.frames, 5U);
  for (const double expected : {8, 6, 4, 2, 0, 0}) {
    EXPECT_NEAR(mean.add({0, 0, -1.9}, 0, 0).axial_force_n, expected, 1e-12);
  }
}

/// Decodes the appended data of a .vti as VTK's zlib reader does.
std::vector<float> vti_values(const std::string& bytes) {
  std::size_t at = bytes.find('_', bytes.find("<AppendedData")) + 1;
  const auto number = [&] {
    std::uint64_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    at += sizeof value;
    return value;
  };
  const std::uint64_t blocks = number(), full = number(), last = number();
  std::vector<std::uint64_t> sizes(blocks);
  for (auto& size : sizes) size = number();
  std::vector<float> values;
  for (std::uint64_t b = 0; b < blocks; ++b) {
    std::vector<float> block((b + 1 == blocks && last != 0 ? last : full) / sizeof(float));
    uLongf size = block.size() * sizeof(float);
    EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(block.data()), &size,
                         reinterpret_cast<const Bytef*>(bytes.data() + at), sizes[b]),
              Z_OK);
    at += sizes[b];
    values.insert(values.end(), block.begin(), block.end());
  }
  return values;
}

TEST(Vti, HoldsDensityTimesFill) {
  const TempDir dir;
  FilledVoxmap voxmap(VoxelGrid{{90, 70, 60}, 0.5, {1, 2, 3}});
  for (std::int64_t e = 0; e < voxmap.grid.size(); ++e) {
    voxmap.grade.set(voxmap.grid.coord(e), static_cast<std::uint8_t>(e % 251));
  }
  voxmap.fill.set({5, 6, 7}, 32768);
  write_vti(dir.path() + "/a.vti", voxmap);
  const std::string bytes = file_bytes(dir.path() + "/a.vti");
  EXPECT_NE(bytes.find("WholeExtent=\"0 89 0 69 0 59\" Origin=\"1.25 2.25 3.25\" Spacing=\"0.5 0.5 0.5\""),
            std::string::npos);
  const auto values = vti_values(bytes);
  ASSERT_EQ(values.size(), static_cast<std::size_t>(voxmap.grid.size()));
  for (std::size_t e = 0; e < values.size(); ++e) {
    const Vec3i voxel = voxmap.grid.coord(static_cast<std::int64_t>(e));
    const double fill = voxmap.fill.get(voxel) / 65535.0;
    ASSERT_FLOAT_EQ(values[e], static_cast<float>(0.008 * voxmap.grade.get(voxel) * fill));
  }
}

}  // namespace
}  // namespace reamsim::test
