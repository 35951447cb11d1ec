// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <numeric>

#include "sim/base/statistics.h"
#include "sim/bone/bone.h"
#include "sim/scene/load_bone.h"
#include "tests/anatomy/reamed_fixture.h"

namespace reamsim::test {
namespace {

double radians(double degrees) {
  return degrees * kPi / 180;
}

Rigid turned(double degrees, const Vec3& axis) {
  Rigid out = Rigid::Identity();
  out.linear() = Eigen::AngleAxisd(radians(degrees), axis.normalized()).toRotationMatrix();
  return out;
}

TEST(BoneMetrics, ACapOfKnownRadiusAndDepth) {
  const double radius = 29;
  const double depth = 4;
  Block block({40, 40, 8}, kVoxel, 1.8);
  const Vec3 apex(0.13, -0.21, -depth);  // nowhere near the voxels' centres
  block.ream(cap(apex, radius));
  const BoneMetrics found = block.measure();

  const double volume = kPi * depth * depth * (radius - depth / 3);
  EXPECT_NEAR(found.removed.total_mm3, volume, 2e-4 * volume);
  EXPECT_DOUBLE_EQ(found.removed.dense_mm3, found.removed.total_mm3);
  EXPECT_EQ(found.removed.trabecular_mm3, 0);

  ASSERT_TRUE(found.depth);
  const double area = kPi * depth * (2 * radius - depth);
  EXPECT_NEAR(found.depth->max_mm, depth, 0.01);
  EXPECT_NEAR(found.depth->area_mm2, area, 0.01 * area);
  EXPECT_NEAR(found.depth->mean_mm, volume / area, 0.01 * volume / area);
  // 95 % of the area lies outside 5 % of it: r² = a²/20 (closed form of the depth there).
  const double r2 = area / kPi / 20;
  EXPECT_NEAR(found.depth->p95_mm, std::sqrt(radius * radius - r2) - (radius - depth), 0.01);

  ASSERT_TRUE(found.face && found.face->sphere);
  EXPECT_TRUE(found.face->spherical);
  EXPECT_TRUE(found.face->concave);
  EXPECT_NEAR(found.face->sphere->radius_mm, radius, 0.02);
  EXPECT_LT((found.face->sphere->center_mm - (apex + radius * Vec3::UnitZ())).norm(), 0.02);
  EXPECT_LT(found.face->sphere->rms_mm, 0.02 * kVoxel);
  EXPECT_EQ(found.perforation->holes, 0);
  EXPECT_EQ(found.perforation->rim_area_mm2, 0);
  EXPECT_FALSE(found.planning);
}

TEST(BoneMetrics, ACapSeenFromATiltedAxis) {
  const double radius = 29;
  Block block({40, 40, 8}, kVoxel, 0.4);
  block.ream(cap({0, 0, -4}, radius));
  for (const double tilt : {15.0, 35.0}) {
    const Rigid bone_from_tool = turned(tilt, {1, 2, 0.3});
    const ColumnMap map = map_columns(block.reamed(), bone_from_tool, {});
    double sum = 0;
    for (const Column& column : map.columns) sum += column.depth_mm;
    const double volume = kPi * 16 * (radius - 4.0 / 3);
    EXPECT_NEAR(sum * map.pitch_mm * map.pitch_mm, volume, 1e-3 * volume) << "tilt " << tilt;
    const BoneMetrics found = block.measure(bone_from_tool);
    EXPECT_EQ(found.removed.dense_mm3, 0);
    ASSERT_TRUE(found.face && found.face->sphere) << "tilt " << tilt;
    EXPECT_NEAR(found.face->sphere->radius_mm, radius, 0.1) << "tilt " << tilt;
    EXPECT_LT((found.face->sphere->center_mm - Vec3(0, 0, radius - 4)).norm(), 0.1) << "tilt " << tilt;
  }
}

TEST(BoneMetrics, WholeVoxelsLeaveAFaceOfSteps) {
  Block block({40, 40, 8}, kVoxel, 1.8);
  block.ream_whole_voxels(cap({0.13, -0.21, -4}, 29));
  const BoneMetrics found = block.measure();
  ASSERT_TRUE(found.face && found.face->spherical);
  // A touched voxel goes whole, which takes more on slopes than on the level: the sphere comes out wider.
  EXPECT_NEAR(found.face->sphere->radius_mm, 29, 3 * kVoxel);
  EXPECT_LT(found.face->sphere->rms_mm, 0.5 * kVoxel);
  // Too deep by about half a voxel, as all that `remove` does.
  EXPECT_NEAR(found.depth->max_mm, 4 + 0.5 * kVoxel, 0.5 * kVoxel);
}

TEST(BoneMetrics, ATiltedPlaneHasKnownVersionAndInclination) {
  // Retroversion 10°, superior tilt 6°, on a left scapula: lateral is +z here, superior +y, anterior −x.
  const double version = radians(10);
  const double inclination = radians(6);
  const Vec3 normal(std::sin(version) * std::cos(inclination), std::sin(inclination),
                    std::cos(version) * std::cos(inclination));
  Block block({40, 40, 12}, kVoxel, 1.8);
  const Vec3 middle(0.1, -0.2, -4.1);
  block.ream(both(above_plane(middle, normal), rod(middle, normal, 11)));
  Rigid bone_from_tool = Rigid::Identity();
  bone_from_tool.linear() = smallest_rotation(Vec3::UnitZ(), normal).toRotationMatrix();
  bone_from_tool.translation() = middle;
  const ScapularAxes axes{.lateral = Vec3::UnitZ(), .superior = Vec3::UnitY(), .anterior = -Vec3::UnitX()};
  const BoneMetrics found = block.measure(bone_from_tool, {}, {.scapula = axes, .glenoid = {}});
  ASSERT_TRUE(found.face && found.face->plane && found.orientation);
  EXPECT_FALSE(found.face->spherical);
  EXPECT_LT(found.face->plane->rms_mm, 0.02 * kVoxel);
  EXPECT_NEAR((found.face->plane->point_mm - middle).dot(normal), 0, 0.01);
  ASSERT_TRUE(found.orientation->planes);
  const PlaneOrientation& planes = *found.orientation->planes;
  ASSERT_TRUE(planes.before && planes.after && planes.change);
  EXPECT_NEAR(planes.before->version_deg, 0, 0.05);
  EXPECT_NEAR(planes.before->inclination_deg, 0, 0.05);
  EXPECT_NEAR(planes.after->version_deg, 10, 0.05);
  EXPECT_NEAR(planes.after->inclination_deg, 6, 0.05);
  EXPECT_NEAR(planes.change->version_deg, 10, 0.1);
  EXPECT_NEAR(planes.turned_deg, 180 / kPi * std::acos(normal.z()), 0.05);
  ASSERT_TRUE(found.orientation->reamed.value) << found.orientation->reamed.reason;
  EXPECT_NEAR(found.orientation->reamed.value->version_deg, 10, 0.05);
  EXPECT_NEAR(found.orientation->reamed.value->inclination_deg, 6, 0.05);
  EXPECT_NEAR(found.orientation->reamer->version_deg, 10, 1e-9);
  EXPECT_NEAR(found.orientation->reamer->inclination_deg, 6, 1e-9);

  const BoneMetrics unknown = block.measure(bone_from_tool, {}, {.scapula = {}, .glenoid = axes});
  EXPECT_FALSE(unknown.orientation->planes->before || unknown.orientation->planes->after);
  EXPECT_FALSE(unknown.orientation->reamed.value || unknown.orientation->reamer);
  EXPECT_NEAR(unknown.orientation->planes->change->inclination_deg, 6, 0.1);
  EXPECT_FALSE(block.measure(bone_from_tool).orientation->planes->change);
}

TEST(BoneMetrics, FaceAnglesAreThoseOfTheGlenoidPhantom) {
  for (const BodySide side : {BodySide::left, BodySide::right}) {
    BoneSettings settings;
    settings.source = BoneSource::phantom;
    settings.side = side;
    settings.voxel_mm = 2;
    settings.phantom.version_deg = 12;
    settings.phantom.inclination_deg = 7;
    Diagnostics report;
    const Bone bone = load_bone(settings, report);
    ASSERT_TRUE(bone.scapula && bone.glenoid);
    const FaceAngles angles = face_angles(bone.glenoid->bone_from_glenoid.linear().col(2), *bone.scapula);
    EXPECT_NEAR(angles.version_deg, 12, 1e-9) << name_of(side);
    EXPECT_NEAR(angles.inclination_deg, 7, 1e-9) << name_of(side);
  }
}

TEST(BoneMetrics, LandmarksGiveTheScapularFrame) {
  // A left scapula in LPS: the face looks left, the trigonum lies to its right, the inferior angle below.
  GlenoidSettings glenoid;
  glenoid.landmarks = LandmarkSettings{
      .glenoid_center_mm = {0, 0, 0}, .trigonum_spinae_mm = {-100, 0, 0}, .inferior_angle_mm = {-90, 0, -120}};
  const ScapularAxes left = axes_of(*glenoid_frame(glenoid, BodySide::left), BodySide::left);
  EXPECT_LT((left.lateral - Vec3::UnitX()).norm(), 1e-12);
  EXPECT_LT((left.superior - Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_LT((left.anterior + Vec3::UnitY()).norm(), 1e-12);  // posterior is +y
  glenoid.landmarks->trigonum_spinae_mm.x() = 100;
  glenoid.landmarks->inferior_angle_mm.x() = 90;
  const ScapularAxes right = axes_of(*glenoid_frame(glenoid, BodySide::right), BodySide::right);
  EXPECT_LT((right.lateral + Vec3::UnitX()).norm(), 1e-12);
  EXPECT_LT((right.anterior + Vec3::UnitY()).norm(), 1e-12);
}

TEST(BoneMetrics, AnUntouchedBone) {
  const Block block({10, 10, 4}, kVoxel, 1.8);
  const BoneMetrics found = block.measure();
  EXPECT_EQ(found.removed.total_mm3, 0);
  EXPECT_FALSE(found.depth || found.face || found.orientation || found.remaining_dense || found.perforation);
  EXPECT_TRUE(depth_map(block.reamed(), {}, Rigid::Identity()).columns.empty());
}

TEST(BoneMetrics, ABoneThatWasPartlyFilledBefore) {
  // Its surface lies 0.3 mm below the voxels' top; what a later run takes is measured from there.
  Block block({20, 20, 6}, kVoxel, 1.8);
  block.ream(above_plane({0, 0, -0.3}, Vec3::UnitZ()));
  block.before = block.after.fill;
  block.ream(both(above_plane({0, 0, -1.12}, Vec3::UnitZ()), rod({0, 0, 0}, Vec3::UnitZ(), 7)));
  const BoneMetrics found = block.measure();
  // 12 points a voxel see a surface to within 1/24 of one.
  const double accuracy = kVoxel / 24;
  EXPECT_NEAR(found.depth->max_mm, 0.82, 2 * accuracy);
  EXPECT_NEAR(found.face->plane->point_mm.z(), -1.12, accuracy);
  EXPECT_NEAR(found.face->plane_before->point_mm.z(), -0.3, 3 * accuracy);
  EXPECT_NEAR(found.removed.total_mm3, kPi * 49 * 0.82, 0.015 * kPi * 49);
}

TEST(BoneMetrics, VolumeByDensityClass) {
  // 1.2 mm of the upper layer and 0.8 mm of the lower one, in a square of 10 × 10 mm.
  Block block({20, 20, 6}, 0.4, [](const Vec3& p) { return p.z() > -1.2 ? 1.0 : 0.992; });
  const Solid square = [](const Vec3& p) { return std::max({std::abs(p.x()) - 5, std::abs(p.y()) - 5, -2 - p.z()}); };
  block.ream(square);
  const RemovedVolume found = removed_volume(block.reamed(), 1.0);
  EXPECT_NEAR(found.dense_mm3, 120, 1e-2);  // 1.0 g/cm³ is dense: the threshold belongs to it
  EXPECT_NEAR(found.trabecular_mm3, 80, 1e-2);
  EXPECT_DOUBLE_EQ(found.total_mm3, found.dense_mm3 + found.trabecular_mm3);
}

TEST(FaceFit, RefusesWhatHasNoAnswer) {
  EXPECT_FALSE(fit_plane({{0, 0, 0}, {1, 0, 0}}, Vec3::UnitZ()));
  EXPECT_FALSE(fit_plane({{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {5, 5, 0}}, Vec3::UnitZ()));
  EXPECT_FALSE(fit_sphere({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_FALSE(fit_sphere({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {3, 5, 0}}));  // flat
}

TEST(Statistics, QuantilesLieBetweenNeighbours) {
  EXPECT_EQ(quantile({}, 0.5), 0);
  EXPECT_EQ(mean({}), 0);
  EXPECT_DOUBLE_EQ(quantile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(quantile({4, 1, 3, 2}, 1), 4);
  EXPECT_DOUBLE_EQ(quantile({4, 1, 3, 2}, 0), 1);
  EXPECT_DOUBLE_EQ(mean({4, 1, 3, 2}), 2.5);
}

}  // namespace
}  // namespace reamsim::test
