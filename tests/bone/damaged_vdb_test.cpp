// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <random>

#include "bone_fixture.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/scene/load_bone.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

class DamagedVdb : public ::testing::Test {
 protected:
  void SetUp() override {
    BoneSettings settings = phantom(PhantomShape::sphere, 0.5);
    settings.phantom.radius_mm = 4;
    Diagnostics report;
    bone_ = load_bone(settings, report).copy_voxels();
    write_bone_vdb(path_, bone_, {{5, 1}}, {{"scenario", "none"}});
    whole_ = file_bytes(path_);
  }
  void put(const std::string& bytes) const { std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes; }
  std::string error() const {
    return input_error([this] { read_stored_bone(path_); });
  }
  /// The same grids as another program would write them: without the checksum.
  [[nodiscard]] std::string foreign_bytes() const {
    openvdb::io::File in(path_);
    in.open(false);
    const openvdb::GridPtrVec grids = {in.readGrid("density"), in.readGrid("fill")};
    in.close();
    const std::string other = dir_.path() + "/foreign.vdb";
    openvdb::io::File(other).write(grids);
    return file_bytes(other);
  }

  TempDir dir_;
  std::string path_ = dir_.path() + "/bone.vdb";
  std::string whole_;
  FilledVoxmap bone_;
};

TEST_F(DamagedVdb, NoVdbAtAll) {
  EXPECT_THAT(input_error([this] { read_stored_bone(dir_.path() + "/none.vdb"); }), HasSubstr("no such file"));
  EXPECT_THAT(input_error([this] { read_stored_bone(dir_.path()); }), HasSubstr("not a file"));
  put("");
  EXPECT_THAT(error(), HasSubstr("empty"));
  put("this is no VDB file, whatever its name says");
  EXPECT_THAT(error(), HasSubstr("not a VDB file"));
}

TEST_F(DamagedVdb, EveryTruncationIsAnInputError) {
  for (std::size_t length = 1; length < whole_.size(); length += 1 + whole_.size() / 211) {
    put(whole_.substr(0, length));
    EXPECT_THAT(error(), HasSubstr(path_)) << length;
  }
  put(whole_.substr(0, whole_.size() - 1));
  EXPECT_THAT(error(), HasSubstr("checksum"));
}

TEST_F(DamagedVdb, AFlippedByteIsAnInputErrorOrChangesNothing) {
  constexpr unsigned kSeed = 11;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937 random(kSeed);
  int errors = 0;
  constexpr int kRounds = 400;
  for (int round = 0; round < kRounds; ++round) {
    std::string bytes = whole_;
    bytes[random() % (round % 2 == 0 ? bytes.size() : 2000)] ^= static_cast<char>(1 + random() % 255);
    put(bytes);
    try {
      EXPECT_EQ(read_stored_bone(path_).voxmap.grade, bone_.grade);  // the flip hit the mark of the checksum itself
    } catch (const InputError&) {
      ++errors;
    }
  }
  EXPECT_GE(errors, kRounds * 95 / 100);
}

TEST_F(DamagedVdb, ForeignFilesNeverCrashOrHang) {
  constexpr unsigned kSeed = 12;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937 random(kSeed);
  const std::string foreign = foreign_bytes();
  put(foreign);
  EXPECT_EQ(read_stored_bone(path_).voxmap.grade, bone_.grade);
  for (int round = 0; round < 60; ++round) {
    std::string bytes = foreign;
    if (round % 3 == 0) {
      bytes.resize(1 + random() % bytes.size());
    } else {
      for (int flips = 0; flips < 2; ++flips) {
        bytes[random() % std::min<std::size_t>(bytes.size(), 3000)] ^= static_cast<char>(1 + random() % 255);
      }
    }
    put(bytes);
    try {
      read_stored_bone(path_);     // a changed number may go unseen; only a crash would end this test
    } catch (const InputError&) {  // as good
    }
  }
}

TEST_F(DamagedVdb, GarbageBehindTheMagicNumber) {
  constexpr unsigned kSeed = 13;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937 random(kSeed);
  for (int round = 0; round < 20; ++round) {
    std::string bytes = whole_.substr(0, 8);
    for (int i = 0; i < 500; ++i) bytes.push_back(static_cast<char>(random()));
    put(bytes);
    EXPECT_THAT(error(), HasSubstr("damaged"));
  }
}

}  // namespace
}  // namespace reamsim::test
