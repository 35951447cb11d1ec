// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// bone.ct.separate: humerus, on a joint with closed forms and on a real scan.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "sim/base/error.h"
#include "sim/bone/bone.h"
#include "sim/scan/ct_import.h"
#include "sim/scenario/parse.h"
#include "sim/scene/load_bone.h"
#include "test_images.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

constexpr double kHead_mm = 23;
const Vec3 kCenter(30, 1, 2);  // of the head

/// A shell of 2 mm round trabecular bone; `depth`: below its surface, mm.
double bone_hu(double depth) {
  if (depth < 0) return 40;  // cartilage and muscle
  return depth < 2 ? 700 : 320;
}

/// A head with its shaft, and a scapula of 30 mm behind a concave face `gap` mm from it; x points to the patient's
/// left.
std::function<double(const Vec3&)> joint(double gap) {
  return [gap](const Vec3& p) {
    const Vec3 from = p - kCenter;
    const double shaft = std::min(11 - std::hypot(from.x() - 6, from.y()), -from.z());
    const double humerus = std::max(kHead_mm - from.norm(), shaft);
    const double face = from.norm() - (kHead_mm + gap);
    const double block = std::min({face, 14 - std::abs(p.y()), 18 - std::abs(p.z()), p.x() + 25, 16 - p.x()});
    return std::max(bone_hu(humerus), bone_hu(block));
  };
}

class HumeralHeadTest : public ::testing::Test {
 protected:
  BoneSettings write(double gap) {
    image_.dims = {92, 62, 92};
    image_.spacing_mm = Vec3::Constant(1);
    image_.origin_mm = Vec3(-32, -30, -46);
    image_.sample(joint(gap));
    write_image<std::int16_t>(image_, folder_.file("ct.nrrd"));
    BoneSettings out = settings_for(folder_.file("ct.nrrd"), 1);
    out.side = BodySide::left;
    out.ct.separate = Separate::humerus;
    out.glenoid.near_mm = Vec3(8, 0, 0);
    return out;
  }
  std::string said(const std::vector<std::string>& lines) const {
    std::string all;
    for (const std::string& line : lines) all += line + "\n";
    return all;
  }

  TempFolder folder_;
  TestImage image_;
  Diagnostics report_;
};

TEST_F(HumeralHeadTest, IsCutOffAlongTheJointGap) {
  const FilledVoxmap scapula = voxmap_from_ct(write(3), report_);
  EXPECT_THAT(said(report_.notes), HasSubstr("humeral head: sphere of radius 2"));
  EXPECT_THAT(said(report_.warnings), Not(HasSubstr("touch")));
  EXPECT_EQ(grade_at(scapula, kCenter), 0) << "the head is cut off";
  EXPECT_EQ(grade_at(scapula, kCenter + Vec3(6, 0, -40)), 0) << "the shaft is another piece";
  EXPECT_NE(grade_at(scapula, Vec3(-10, 0, 0)), 0) << "the scapula is there";
  // The face keeps its place: 26 mm from the centre of the head.
  EXPECT_EQ(grade_at(scapula, Vec3(kCenter.x() - kHead_mm - 3 + 1.2, 1, 2)), 0);
  EXPECT_NE(grade_at(scapula, Vec3(kCenter.x() - kHead_mm - 3 - 1.2, 1, 2)), 0);
}

TEST_F(HumeralHeadTest, IsFoundFromPointsRoundTheCentreOfTheFace) {
  for (const Vec3& off : {Vec3(6, 0, 0), Vec3(-6, 0, 0), Vec3(0, 6, 2), Vec3(-2, -4, 6)}) {
    BoneSettings settings = write(3);
    *settings.glenoid.near_mm += off;
    Diagnostics report;
    const FilledVoxmap scapula = voxmap_from_ct(settings, report);
    EXPECT_EQ(grade_at(scapula, kCenter), 0) << off.transpose();
    EXPECT_NE(grade_at(scapula, Vec3(-10, 0, 0)), 0) << off.transpose();
  }
}

TEST_F(HumeralHeadTest, BonesThatTouchAreSaid) {
  BoneSettings settings = write(0.3);
  voxmap_from_ct(settings, report_);
  EXPECT_THAT(said(report_.warnings), HasSubstr("humerus and scapula touch in"));
  EXPECT_THAT(said(report_.warnings), HasSubstr("bone.ct.label_map"));
}

TEST_F(HumeralHeadTest, WhereThereIsNoneItIsAnInputError) {
  BoneSettings settings = write(3);
  settings.glenoid.near_mm = Vec3(-26, 0, 0);
  try {
    voxmap_from_ct(settings, report_);
    FAIL() << "no InputError";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("bone.ct.separate: no head of a humerus next to the glenoid at"));
  }
}

TEST_F(HumeralHeadTest, IsFoundInAWholeScanWithTheFaceOppositeToIt) {
  const std::vector<ct::Joint> joints = joints_in_scan(write(3), report_);
  ASSERT_EQ(joints.size(), 1U);
  EXPECT_LE((joints[0].head.center_mm - kCenter).norm(), 0.7);
  EXPECT_NEAR(joints[0].head.radius_mm, kHead_mm, 0.7);
  EXPECT_GE(joints[0].gap_fraction, 0.8);
  // The middle of the face, 26 mm from the centre of the head.
  EXPECT_LE((joints[0].near_mm - (kCenter - Vec3(kHead_mm + 3, 0, 0))).norm(), 4);
}

TEST_F(HumeralHeadTest, AScanOfTwoSlicesHasNoJoint) {
  BoneSettings settings = write(3);
  image_.dims = {92, 62, 2};
  image_.value.clear();
  image_.sample(joint(3));
  write_image<std::int16_t>(image_, folder_.file("slices.nrrd"));
  settings.ct.path = folder_.file("slices.nrrd");
  EXPECT_TRUE(joints_in_scan(settings, report_).empty());
}

TEST(HumeralHeadOfAScan, GlenoidAndHeadAreFoundFromOnePoint) {
  const std::string scan = data_file("shoulder_ct/shoulder_left.nrrd");
  if (!std::filesystem::exists(scan)) GTEST_SKIP() << "no " << scan << "; set REAMSIM_DATA";
  BoneSettings settings = parse_scenario(REAMSIM_TRAJECTORIES "/ct_shoulder.yaml", {"bone.voxel_mm=0.6"}).bone;
  settings.ct.cut_spheres.clear();
  settings.ct.seed_mm.reset();
  settings.ct.separate = Separate::humerus;
  const Vec3 center = *settings.glenoid.center_mm, normal = settings.glenoid.normal->normalized();
  settings.glenoid = {};
  settings.glenoid.near_mm = center + Vec3(3, 2, -4);
  settings.surface_voxels = SurfaceVoxels::partial;
  Diagnostics report;
  const Bone bone = load_bone(settings, report);
  const Rigid frame = bone.glenoid->bone_from_glenoid;
  // The centre that was measured lies in the joint gap, 1.3 to 1.8 mm in front of the bone.
  const Vec3 away = frame.translation() - center;
  const double along_mm = away.dot(normal);
  std::cout << "centre " << (away - along_mm * normal).norm() << " mm across, " << along_mm
            << " mm along the normal; normal " << std::acos(frame.linear().col(2).dot(normal)) * 180 / M_PI << " deg\n";
  EXPECT_LE(away.norm(), 2);
  EXPECT_LE(std::acos(frame.linear().col(2).dot(normal)) * 180 / M_PI, 6);
  EXPECT_GT(frame.linear()(2, 1), 0.7) << "superior";
}

TEST(GlenoidOfAMesh, IsFoundFromOnePoint) {
  const std::string mesh = data_file("scapula_mesh/scapula_left.stl");
  if (!std::filesystem::exists(mesh)) GTEST_SKIP() << "no " << mesh << "; set REAMSIM_DATA";
  BoneSettings settings = parse_scenario(REAMSIM_TRAJECTORIES "/mesh_scapula.yaml", {"bone.voxel_mm=0.6"}).bone;
  const Vec3 center = *settings.glenoid.center_mm, normal = settings.glenoid.normal->normalized();
  settings.glenoid = {};
  settings.glenoid.near_mm = center + Vec3(-2, 3, 4);
  settings.surface_voxels = SurfaceVoxels::partial;
  Diagnostics report;
  const Rigid frame = load_bone(settings, report).glenoid->bone_from_glenoid;
  // The point that was measured is the middle of a plane through the rim. Along its normal the surface of the mesh lies
  // 2.2 mm behind it: there the bone is, on which the frame's origin lies.
  constexpr double kBehindPlane_mm = 2.2;
  const Vec3 away = frame.translation() - center;
  const double along_mm = away.dot(normal), across_mm = (away - along_mm * normal).norm();
  std::cout << "centre " << across_mm << " mm across, " << along_mm << " mm along the normal; normal "
            << std::acos(frame.linear().col(2).dot(normal)) * 180 / M_PI << " deg\n";
  EXPECT_LE((away + kBehindPlane_mm * normal).norm(), 2);
  EXPECT_LE(std::acos(frame.linear().col(2).dot(normal)) * 180 / M_PI, 6);
  EXPECT_LT(frame.linear()(2, 1), -0.9) << "superior";
}

}  // namespace
}  // namespace reamsim::test
