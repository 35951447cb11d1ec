// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Bones on disk: found by content, never a wrong one.
#include "sim/scene/bone_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "sim/base/error.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test::bone_store_tests {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;

class BoneStoreTest : public testing::Test {
 protected:
  /// A bone with a value in every member, and messages.
  static Bone full_bone(Diagnostics& report) {
    FilledVoxmap voxels(VoxelGrid{{16, 8, 24}, 0.25, {1, -2, 3}});
    for_each_voxel({2, 2, 2}, {13, 6, 20}, [&](const Vec3i& v) {
      voxels.grade.set(v, static_cast<std::uint8_t>(1 + v.sum()));
      voxels.fill.set(v, static_cast<std::uint16_t>(7 * v.x() + 1000 * v.z()));
    });
    voxels.frame = "phantom";
    voxels.layers = BoneLayers{1.5, 1.8, 0.4};
    voxels.mapping.ash_fraction = 0.5;
    Bone bone(std::move(voxels), GlenoidFrame{Rigid(Eigen::Translation3d(4, 5, 6))});
    bone.landmarks = LandmarkSettings{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
    bone.scapula = ScapularAxes{};
    bone.side = BodySide::left;
    bone.rim_mm = {{1, 0, 0}, {0, 1, 0}};
    Segmentation& segmentation = bone.segmentation.emplace();
    segmentation.method = "threshold";
    segmentation.by_seed = true;
    segmentation.pieces = 12;
    ScanPlane& plane = segmentation.planes.emplace_back();
    plane.name = "axial";
    plane.columns = 2;
    plane.hu = {1, 2};
    plane.field = {3, 4};
    report.note("a note");
    report.warn("a warning of " + std::string(REAMSIM_VERSION));
    report.list("a list");
    return bone;
  }
  static void expect_full(const Bone& bone, const Diagnostics& report) {
    Diagnostics said;
    const Bone wanted = full_bone(said);
    EXPECT_TRUE(bone.voxmap->grade == wanted.voxmap->grade);
    EXPECT_EQ(bone.voxmap->grid.origin_mm, wanted.voxmap->grid.origin_mm);
    EXPECT_EQ(bone.voxmap->grid.voxel_mm, 0.25);
    for_each_voxel(wanted.voxmap->grid.dims,
                   [&](const Vec3i& v) { ASSERT_EQ(bone.fill.get(v), wanted.fill.get(v)) << v.transpose(); });
    EXPECT_EQ(bone.fill.changed().size(), wanted.fill.changed().size());
    EXPECT_EQ(bone.voxmap->frame, "phantom");
    EXPECT_EQ(bone.voxmap->layers->trabecular_g_cm3, 0.4);
    EXPECT_EQ(bone.voxmap->mapping.ash_fraction, 0.5);
    EXPECT_TRUE(bone.glenoid->bone_from_glenoid.isApprox(wanted.glenoid->bone_from_glenoid, 0));
    EXPECT_EQ(bone.landmarks->inferior_angle_mm, Vec3(7, 8, 9));
    EXPECT_EQ(bone.scapula->anterior, Vec3::UnitZ());
    EXPECT_EQ(bone.side, BodySide::left);
    EXPECT_THAT(bone.rim_mm, ElementsAre(Vec3(1, 0, 0), Vec3(0, 1, 0)));
    ASSERT_TRUE(bone.segmentation);
    EXPECT_EQ(bone.segmentation->method, "threshold");
    EXPECT_TRUE(bone.segmentation->by_seed);
    EXPECT_EQ(bone.segmentation->pieces, 12);
    EXPECT_THAT(bone.segmentation->planes.at(0).field, ElementsAre(3, 4));
    EXPECT_EQ(report.notes, said.notes);
    EXPECT_EQ(report.warnings, said.warnings);
    EXPECT_EQ(report.listings, said.listings);
  }

  /// Finds or loads the bone of `settings_`, checks it, and returns whether it was loaded.
  bool loads(const BoneStore& store) {
    bool loaded = false;
    Diagnostics report;
    const Bone bone = store.find_or_load(settings_, report, [&](Diagnostics& said) {
      loaded = true;
      return full_bone(said);
    });
    expect_full(bone, report);
    return loaded;
  }
  std::string only_file() const {
    std::vector<std::string> files;
    for (const auto& entry : fs::directory_iterator(folder_)) files.push_back(entry.path().string());
    EXPECT_EQ(files.size(), 1U);
    return files.empty() ? "" : files[0];
  }

  TempDir dir_;
  fs::path folder_ = dir_.path() + "/cache/bones";
  BoneStore store_{folder_};
  BoneSettings settings_;
};

TEST_F(BoneStoreTest, ABoneIsFoundAgainWithAllThatWasSaid) {
  EXPECT_TRUE(loads(store_));
  EXPECT_FALSE(loads(store_));
  EXPECT_EQ(store_.size().first, 1);
  EXPECT_EQ(fs::status(only_file()).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(fs::status(folder_).permissions(), fs::perms::owner_all);
  store_.clear();
  EXPECT_EQ(store_.size().first, 0);
  EXPECT_TRUE(loads(store_));
}

TEST_F(BoneStoreTest, OtherSettingsAndOtherBytesOfAFileAreAnotherBone) {
  settings_.source = BoneSource::ct;
  settings_.ct.path = dir_.path() + "/scan.nrrd";
  std::ofstream(settings_.ct.path) << "one";
  EXPECT_TRUE(loads(store_));
  settings_.ct.threshold_hu = 250;
  EXPECT_TRUE(loads(store_));
  EXPECT_FALSE(loads(store_));
  const auto time = fs::last_write_time(settings_.ct.path);
  std::ofstream(settings_.ct.path) << "two";
  fs::last_write_time(settings_.ct.path, time);
  EXPECT_TRUE(loads(store_));
  fs::remove(settings_.ct.path);
  EXPECT_TRUE(loads(store_)) << "whose error names the file";
}

TEST_F(BoneStoreTest, ADamagedFileIsNeverABone) {
  ASSERT_TRUE(loads(store_));
  const std::string path = only_file(), whole = file_bytes(path);
  EXPECT_EQ(whole.find("phantom"), std::string::npos) << "it is encrypted";
  for (std::size_t at = 0; at < whole.size(); at += 1 + whole.size() / 60) {
    std::string broken = whole;
    broken[at] = static_cast<char>(broken[at] ^ 0x10);
    std::ofstream(path, std::ios::binary) << broken;
    EXPECT_TRUE(loads(store_)) << at;
    std::ofstream(path, std::ios::binary) << whole.substr(0, at);
    EXPECT_TRUE(loads(store_)) << "cut off at " << at;
  }
  EXPECT_FALSE(loads(store_));
}

TEST_F(BoneStoreTest, TheLeastRecentlyUsedBonesGo) {
  ASSERT_TRUE(loads(store_));
  const std::uintmax_t one = store_.size().second;
  const BoneStore small(folder_, 2 * one + one / 2);
  for (const double voxel_mm : {0.3, 0.4, 0.5}) {
    settings_.voxel_mm = voxel_mm;
    EXPECT_TRUE(loads(small));
    EXPECT_LE(small.size().second, 2 * one + one / 2);
  }
  settings_.voxel_mm = 0.4;
  EXPECT_FALSE(loads(small));
  settings_.voxel_mm = 0.6;
  EXPECT_TRUE(loads(small));
  settings_.voxel_mm = 0.4;
  EXPECT_FALSE(loads(small)) << "used after that of 0.5 mm";
}

TEST_F(BoneStoreTest, WhereNothingCanBeWrittenBonesAreLoaded) {
  std::ofstream(dir_.path() + "/file") << "no folder";
  const BoneStore nowhere(fs::path(dir_.path()) / "file" / "bones"), off(fs::path{});
  for (const BoneStore* store : {&nowhere, &off}) {
    EXPECT_TRUE(loads(*store));
    EXPECT_TRUE(loads(*store));
  }
}

TEST_F(BoneStoreTest, AScenarioMayTurnItOff) {
  settings_.cache = false;
  EXPECT_TRUE(loads(store_));
  EXPECT_EQ(store_.size().first, 0);
}

TEST_F(BoneStoreTest, AnErrorKeepsWhatWasSaidBefore) {
  Diagnostics report;
  const auto load = [](Diagnostics& said) -> Bone {
    said.warn("before");
    throw InputError("wrong");
  };
  EXPECT_THROW(store_.find_or_load(settings_, report, load), InputError);
  EXPECT_THAT(report.warnings, ElementsAre("before"));
  EXPECT_EQ(store_.size().first, 0);
}

}  // namespace
}  // namespace reamsim::test::bone_store_tests
