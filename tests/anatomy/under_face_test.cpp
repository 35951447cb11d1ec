// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include "tests/anatomy/reamed_fixture.h"

namespace reamsim::test {
namespace {

/// Two millimetres of cortex on trabecular bone.
Block layered() {
  return {{40, 40, 8}, kVoxel, [](const Vec3& p) { return p.z() > -2 ? 1.8 : 0.4; }};
}

Solid flat_tool(double depth) {
  return both(above_plane({0, 0, -depth}, Vec3::UnitZ()), rod({0, 0, 0}, Vec3::UnitZ(), 12));
}

TEST(RemainingDenseBone, UnderAFlatFace) {
  Block block = layered();
  block.ream(flat_tool(1.3));
  const auto found = block.measure().remaining_dense;
  ASSERT_TRUE(found);
  // 12 points a voxel see the face to within 1/24 of one.
  EXPECT_NEAR(found->mean_mm, 0.7, kVoxel / 24);
  EXPECT_NEAR(found->least_mm, 0.7, kVoxel / 24);
  EXPECT_NEAR(found->p05_mm, 0.7, kVoxel / 24);
  EXPECT_EQ(found->exposed_percent, 0);
}

TEST(RemainingDenseBone, NoneInTrabecularBone) {
  Block block = layered();
  block.ream(flat_tool(2.6));
  const auto found = block.measure().remaining_dense;
  ASSERT_TRUE(found);
  EXPECT_EQ(found->mean_mm, 0);
  EXPECT_EQ(found->exposed_percent, 100);
}

TEST(RemainingDenseBone, UnderASphericalFaceAlongItsNormal) {
  const double radius = 29;
  Block block = layered();
  block.ream(cap({0, 0, -1.4}, radius));
  const ColumnMap map = map_columns(block.reamed(), Rigid::Identity(), {});
  const ReamedFace face = find_face(map, kVoxel);
  const auto found = remaining_dense_bone(block.reamed(), map, face, 1.0);
  ASSERT_TRUE(face.spherical && found);
  // From the sphere's centre the layer's lower side is (R − 1.4 + 2)/cos away.
  double mean_mm = 0;
  for (const ColumnPlace& place : face.columns) {
    const double sine = map.center_mm(place).norm() / radius;
    mean_mm += ((radius + 0.6) / std::sqrt(1 - sine * sine) - radius) / static_cast<double>(face.columns.size());
  }
  EXPECT_NEAR(found->least_mm, 0.6, 0.03);
  EXPECT_NEAR(found->mean_mm, mean_mm, 0.02);
  EXPECT_EQ(found->exposed_percent, 0);
}

TEST(RemainingDenseBone, HalfOfTheFaceIsExposed) {
  Block block({40, 40, 8}, kVoxel, [](const Vec3& p) { return p.x() > 0 && p.z() > -3 ? 1.8 : 0.4; });
  block.ream(flat_tool(1));
  const auto found = block.measure().remaining_dense;
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->exposed_percent, 50, 2.5);
  EXPECT_NEAR(found->mean_mm, 1, 0.05);
  EXPECT_EQ(found->least_mm, 0);
}

TEST(Perforation, OfAPlate) {
  // Three millimetres thick; the cap reaches a millimetre further.
  const double radius = 29;
  Block block({40, 40, 3}, kVoxel, 1.8);
  block.ream(cap({0.13, -0.21, -4}, radius));
  const auto found = block.measure().perforation;
  ASSERT_TRUE(found);
  EXPECT_EQ(found->holes, 1);
  // Where less than a tenth of a voxel is left it counts as nothing.
  const double reach = radius - 1 - kMinDepthVoxels * kVoxel;
  const double area = kPi * (radius * radius - reach * reach);
  EXPECT_NEAR(found->area_mm2, area, 0.02 * area);
  EXPECT_EQ(found->rim_area_mm2, 0);
}

TEST(Perforation, TwoHolesAndNone) {
  Block block({40, 40, 3}, kVoxel, 1.8);
  block.ream(flat_tool(2));
  EXPECT_EQ(block.measure().perforation->holes, 0);
  for (const double x : {-6.0, 6.0}) block.ream(rod({x, 0, 0}, Vec3::UnitZ(), 2.5));
  const auto found = block.measure().perforation;
  EXPECT_EQ(found->holes, 2);
  EXPECT_NEAR(found->area_mm2, 2 * kPi * 6.25, 0.05 * 2 * kPi * 6.25);
}

TEST(Perforation, AnEdgeReamedAwayIsNoHole) {
  Block block({40, 40, 3}, kVoxel, 1.8);
  block.ream([](const Vec3& p) { return 15 - p.x(); });  // all beyond x = 15
  block.ream(flat_tool(1));
  const auto found = block.measure().perforation;
  ASSERT_TRUE(found);
  EXPECT_EQ(found->holes, 0);
  EXPECT_NEAR(found->rim_area_mm2, 5 * 40, 0.02 * 200);
}

/// A plate of 3 mm that stands 5 mm over a floor as far as x = 5; beyond there is only the floor.
Block overhang() {
  Block block({40, 40, 12}, kVoxel, 1.8);
  block.ream([](const Vec3& p) { return std::max(5 - p.x(), -8 - p.z()); });
  block.ream([](const Vec3& p) { return std::max({-15 - p.x(), p.z() + 3, -8 - p.z()}); });
  block.before = block.after.fill;
  return block;
}

TEST(Perforation, ARimOverLowerBoneIsNoHole) {
  Block block = overhang();
  block.ream([](const Vec3& p) { return std::max({4 - p.x(), std::abs(p.y()) - 5, -4 - p.z()}); });
  const auto found = block.measure().perforation;
  ASSERT_TRUE(found);
  EXPECT_EQ(found->holes, 0);
  EXPECT_EQ(found->area_mm2, 0);
  EXPECT_NEAR(found->rim_area_mm2, 1 * 10, 1e-6);
}

TEST(Perforation, AHoleOverLowerBoneIsOne) {
  Block block = overhang();
  block.ream(both(rod({-8, 0, 0}, Vec3::UnitZ(), 2.5), above_plane({0, 0, -4}, Vec3::UnitZ())));
  const auto found = block.measure().perforation;
  ASSERT_TRUE(found);
  EXPECT_EQ(found->holes, 1);
  EXPECT_NEAR(found->area_mm2, kPi * 6.25, 0.05 * kPi * 6.25);
  EXPECT_EQ(found->rim_area_mm2, 0);
}

}  // namespace
}  // namespace reamsim::test
