// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Snapshots: what they bring back, and what becomes of damaged ones.
#include "sim/record/recorder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <filesystem>

#include "sim/base/error.h"
#include "sim/bone/vdb/grids.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

FillBricks patterned(const Vec3i& dims) {
  FillBricks fill(dims);
  for (int i = 0; i < 200; ++i) {
    fill.set({i % dims.x(), (i * 7) % dims.y(), (i * 3) % dims.z()}, static_cast<std::uint16_t>(i * 327));
  }
  return fill;
}

void expect_equal(const FillBricks& a, const FillBricks& b, const Vec3i& dims) {
  for (int z = 0; z < dims.z(); ++z) {
    for (int y = 0; y < dims.y(); ++y) {
      for (int x = 0; x < dims.x(); ++x) ASSERT_EQ(a.get({x, y, z}), b.get({x, y, z})) << x << ' ' << y << ' ' << z;
    }
  }
}

TEST(Snapshot, ChangesAddUpToTheStateBitForBit) {
  const TempDir dir;
  const Vec3i dims(37, 19, 23);
  FillBricks fill = patterned(dims), replay(dims);
  write_snapshot(dir.path(), 0, fill);
  const FillBricks first = fill;
  for (int i = 0; i < 30; ++i) fill.set({i, 18, 22}, 0);
  write_snapshot(dir.path(), 40, fill);
  EXPECT_EQ(snapshot_frames(dir.path()), (std::vector<std::int64_t>{0, 40}));
  apply_snapshot(dir.path(), 0, replay);
  expect_equal(replay, first, dims);
  apply_snapshot(dir.path(), 40, replay);
  expect_equal(replay, fill, dims);
  EXPECT_LT(fs::file_size(dir.path() + "/snapshots/000040.vdb"), fs::file_size(dir.path() + "/snapshots/000000.vdb"));
}

TEST(Snapshot, MissingDamagedOrOfAnotherBone) {
  const TempDir dir;
  FillBricks fill = patterned({37, 19, 23});
  write_snapshot(dir.path(), 1, fill);
  EXPECT_THROW(apply_snapshot(dir.path(), 2, fill), InputError);
  FillBricks small({8, 8, 8});
  EXPECT_THROW(apply_snapshot(dir.path(), 1, small), InputError);
}

class DamagedSnapshot : public testing::Test {
 protected:
  void SetUp() override {
    FillBricks fill = patterned(dims_);
    write_snapshot(dir_.path(), 1, fill);
    whole_ = file_bytes(path_);
  }
  /// The complaint about a snapshot of these bytes; the fill must not have changed.
  std::string error_of(const std::string& bytes) const {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
    FillBricks fill(dims_);
    try {
      apply_snapshot(dir_.path(), 1, fill);
    } catch (const InputError& error) {
      EXPECT_EQ(fill.stored_bricks(), 0U);
      return error.what();
    }
    return "no error";
  }

  TempDir dir_;
  const Vec3i dims_{37, 19, 23};
  const std::string path_ = dir_.path() + "/snapshots/000001.vdb";
  std::string whole_;
};

TEST_F(DamagedSnapshot, EveryTruncationIsAnInputError) {
  EXPECT_THAT(error_of(""), AllOf(HasSubstr(path_), HasSubstr("empty")));
  for (std::size_t length = 1; length < whole_.size(); length += 1 + whole_.size() / 97) {
    EXPECT_THAT(error_of(whole_.substr(0, length)), HasSubstr(path_)) << length << " bytes";
  }
  EXPECT_THAT(error_of(whole_.substr(0, 60)), HasSubstr("checksum is missing"));
  EXPECT_THAT(error_of(whole_.substr(0, whole_.size() / 2)), HasSubstr("checksum does not match"));
  EXPECT_THAT(error_of(whole_.substr(0, whole_.size() - 1)), HasSubstr("checksum does not match"));
  EXPECT_EQ(error_of(whole_), "no error");
}

TEST_F(DamagedSnapshot, EveryFlippedByteIsAnInputError) {
  // All of the header, where the counts and offsets are that OpenVDB would follow, and a sample of the rest.
  for (std::size_t at = 0; at < whole_.size(); at += at < 600 ? 1 : 1 + whole_.size() / 97) {
    std::string bytes = whole_;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x80);
    EXPECT_THAT(error_of(bytes), HasSubstr(path_)) << "byte " << at;
  }
}

TEST_F(DamagedSnapshot, AFileOfAnotherProgramIsNotTrusted) {
  openvdb::io::File(path_).write({make_float_grid(1.0F)});
  EXPECT_THAT(error_of(file_bytes(path_)), HasSubstr("checksum is missing"));
}

TEST_F(DamagedSnapshot, WhatCannotBeWrittenIsARunErrorAndKeepsTheOldFile) {
  FillBricks fill = patterned(dims_);
  fs::create_directory(path_ + ".tmp");  // in the way of the new file
  EXPECT_THROW(write_snapshot(dir_.path(), 1, fill), RunError);
  EXPECT_EQ(file_bytes(path_), whole_);
}

}  // namespace
}  // namespace reamsim::test
