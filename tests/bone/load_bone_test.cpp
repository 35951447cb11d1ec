// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include "bone_fixture.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/scene/load_bone.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

TEST(LoadBone, PhantomIsFittedAndReported) {
  Diagnostics report;
  const Bone bone = load_bone(phantom(PhantomShape::sphere, 0.5), report);
  for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(bone.voxmap->grid.dims[axis] % 8, 0);
  EXPECT_TRUE(bone.glenoid);
  EXPECT_THAT(report.notes, Contains(HasSubstr("voxels of 0.5 mm")));
}

TEST(LoadBone, GlenoidOfTheScenarioReplacesThePhantomsOwn) {
  BoneSettings settings = phantom(PhantomShape::half_space, 1);
  settings.glenoid.center_mm = Vec3(1, 2, 0);
  settings.glenoid.normal = Vec3(0, 0, 1);
  settings.glenoid.superior = Vec3(1, 0, 0);
  Diagnostics report;
  const Bone bone = load_bone(settings, report);
  EXPECT_EQ(bone.glenoid->bone_from_glenoid.translation(), Vec3(1, 2, 0));
}

TEST(LoadBone, DrillsThePilotHole) {
  BoneSettings settings = phantom(PhantomShape::half_space, 0.5);
  settings.pilot_hole = PilotHoleSettings{};
  settings.pilot_hole->frame = PoseFrame::glenoid;
  Diagnostics report;
  EXPECT_EQ(grade_at(load_bone(settings, report), {0.1, 0.1, -10}), 0);
  EXPECT_THAT(report.notes, Contains(HasSubstr("pilot hole")));
  settings.pilot_hole->entry_mm = {0, 0, 500};
  load_bone(settings, report);
  EXPECT_THAT(report.warnings, Contains(HasSubstr("meets no bone")));
}

TEST(LoadBone, VdbGoesOnWhereItStopped) {
  const TempDir dir;
  Diagnostics report;
  Bone bone = load_bone(phantom(PhantomShape::sphere, 0.5), report);
  const Vec3i reamed = bone.voxmap->grid.voxel_of({0, 0, 19.8});
  bone.fill.set(reamed, 777);
  BoneSettings settings;
  settings.source = BoneSource::vdb;
  settings.vdb.path = dir.path() + "/reamed.vdb";
  write_bone_vdb(settings.vdb.path, bone, {}, {});
  const Bone again = load_bone(settings, report);
  EXPECT_EQ(again.voxmap->grid.dims, bone.voxmap->grid.dims);
  EXPECT_EQ(again.voxmap->grade, bone.voxmap->grade);
  EXPECT_EQ(again.fill.get(reamed), 777);
  EXPECT_FALSE(again.glenoid);
  EXPECT_THAT(report.notes, Contains(HasSubstr("from the VDB")));
}

TEST(LoadBone, AVdbThatIsNotInGramsPerCubicCentimetreIsWarnedOf) {
  const TempDir dir;
  BoneSettings settings;
  settings.source = BoneSource::vdb;
  settings.vdb.path = dir.path() + "/hu.vdb";
  openvdb::initialize();
  const auto warnings = [&](float density) {
    auto grid = openvdb::FloatGrid::create(0.0F);
    grid->setName("density");
    grid->fill(openvdb::CoordBBox({0, 0, 0}, {9, 9, 9}), density);
    openvdb::io::File(settings.vdb.path).write({grid});
    Diagnostics report;
    load_bone(settings, report);
    return report.warnings;
  };
  EXPECT_THAT(warnings(2), testing::Not(Contains(HasSubstr("density"))));
  EXPECT_THAT(warnings(800), Contains(HasSubstr("found 800 g/cm3; the most that is represented is 2 g/cm3")));
}

TEST(LoadBone, TheRimIsThePhantomsOwnOrTheScenarios) {
  BoneSettings settings = phantom(PhantomShape::glenoid, 1);
  Diagnostics report;
  const Bone own = load_bone(settings, report);
  ASSERT_GT(own.rim_mm.size(), 60u);
  for (const Vec3& point : own.rim_mm) {
    EXPECT_NEAR((point - Vec3(32, 0, 0)).norm(), 32, 1e-9) << "on the face";
    EXPECT_GT(point.tail<2>().norm(), 8);
    EXPECT_LT(std::abs(point.y()), 13.5);
    EXPECT_LT(std::abs(point.z()), 18);
  }
  for (std::size_t i = 0; i < own.rim_mm.size(); i += 12) settings.glenoid.rim_mm.push_back(own.rim_mm[i]);
  EXPECT_EQ(load_bone(settings, report).rim_mm, settings.glenoid.rim_mm);
  settings.glenoid.rim_mm[2] += Vec3(20, 0, 0);
  EXPECT_THAT(input_error([&] { load_bone(settings, report); }),
              AllOf(HasSubstr("bone.glenoid.rim_mm: point 3, ("),
                    HasSubstr("lies more than 5 mm from the surface of the bone")));
  EXPECT_TRUE(load_bone(phantom(PhantomShape::sphere, 1), report).rim_mm.empty());
}

}  // namespace
}  // namespace reamsim::test
