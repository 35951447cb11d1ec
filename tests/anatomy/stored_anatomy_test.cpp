// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// A bone's glenoid frame, landmarks and side in its VDB.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/bone/vdb/bone_vdb.h"
#include "sim/scene/load_bone.h"
#include "tests/bone/bone_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

class StoredBoneTest : public ::testing::Test {
 protected:
  StoredBoneTest() : original_(load_bone(phantom(PhantomShape::glenoid, 1), report_)) {}

  /// The settings of a bone from a VDB that has the original's voxels and this metadata.
  [[nodiscard]] BoneSettings stored(const Metadata& metadata) const {
    BoneSettings settings;
    settings.source = BoneSource::vdb;
    settings.vdb.path = dir_.path() + "/bone.vdb";
    write_bone_vdb(settings.vdb.path, original_, {}, metadata);
    return settings;
  }
  [[nodiscard]] Metadata anatomy() const {
    return metadata_of(StoredAnatomy{original_.glenoid, original_.landmarks, original_.side});
  }

  Diagnostics report_;
  TempDir dir_;
  Bone original_;
};

TEST_F(StoredBoneTest, FrameLandmarksAndSideComeBackBitForBit) {
  const Bone back = load_bone(stored(anatomy()), report_);
  ASSERT_TRUE(back.glenoid && back.landmarks && back.scapula);
  EXPECT_EQ(back.glenoid->bone_from_glenoid.matrix(), original_.glenoid->bone_from_glenoid.matrix());
  EXPECT_EQ(back.landmarks->trigonum_spinae_mm, original_.landmarks->trigonum_spinae_mm);
  EXPECT_EQ(back.landmarks->inferior_angle_mm, original_.landmarks->inferior_angle_mm);
  EXPECT_EQ(back.scapula->lateral, original_.scapula->lateral);
  EXPECT_EQ(back.scapula->anterior, original_.scapula->anterior);
  EXPECT_EQ(back.side, BodySide::left);
  EXPECT_THAT(report_.notes, Contains("glenoid frame from the VDB"));
}

TEST_F(StoredBoneTest, TheScenarioWinsAndItsContradictionIsNoted) {
  BoneSettings settings = stored(anatomy());
  settings.side = BodySide::right;
  const Rigid& was = original_.glenoid->bone_from_glenoid;
  settings.glenoid.center_mm = was.translation() + Vec3(0, 3, 0);
  settings.glenoid.normal = was.linear().col(2);
  settings.glenoid.superior = was.linear().col(1);
  const Bone back = load_bone(settings, report_);
  EXPECT_EQ(back.side, BodySide::right);
  EXPECT_EQ(back.glenoid->bone_from_glenoid.translation(), *settings.glenoid.center_mm);
  EXPECT_THAT(report_.notes, Contains(HasSubstr("bone.side is right, the VDB says left")));
  EXPECT_THAT(report_.notes,
              Contains(HasSubstr("differs from the glenoid frame of the VDB by 3.00 mm and 0.00 degrees")));
}

TEST_F(StoredBoneTest, AFileWithoutThem) {
  const Bone back = load_bone(stored({}), report_);
  EXPECT_FALSE(back.glenoid);
  EXPECT_FALSE(back.landmarks);
  EXPECT_EQ(back.side, BodySide::unknown);
}

TEST_F(StoredBoneTest, DamagedAnatomyIsAnInputError) {
  const auto said = [&](const char* key, const std::string& text) {
    return input_error([&] { load_bone(stored({{key, text}}), report_); });
  };
  const std::string turned = "0 -1 0 0 1 0 0 0 0 0 1 0 0 0 0 1";
  EXPECT_TRUE(load_bone(stored({{"bone_from_glenoid", turned}}), report_).glenoid);
  for (const std::string wrong :
       {"1 2 3", "hello", "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1", "-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1",
        "1 0 0 nan 0 1 0 0 0 0 1 0 0 0 0 1", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 9 1", "0 -1 0 0 1 0 0 0 0 0 1 0 0 0 0 1 7"}) {
    EXPECT_THAT(said("bone_from_glenoid", wrong), HasSubstr("bone.vdb: bone_from_glenoid: found '"));
  }
  EXPECT_THAT(said("scapula_landmarks_mm", "1 2 3 4"), HasSubstr("expected 9 numbers"));
  EXPECT_THAT(said("bone_side", "up\x1b[2J"), HasSubstr("found 'up\\x1b[2J'"));
}

}  // namespace
}  // namespace reamsim::test
