// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Walls and perforations of pegs in bones with closed forms: within a tenth of a voxel.
#include "tests/anatomy/implant_fixture.h"

namespace reamsim::test {
namespace {

/// A flat disc with one peg.
ImplantSettings pegged(const PegSettings& peg) {
  ImplantSettings out = disc(16);
  out.pegs = {peg};
  return out;
}

PegWall peg_in(const Block& block, const PegSettings& peg, double center_x = 0) {
  ImplantSettings implant = pegged(peg);
  implant.center_mm.x() = center_x;
  const Planning found = plan(block, implant);
  EXPECT_EQ(found.pegs.size(), 1);
  return found.pegs.empty() ? PegWall{} : found.pegs.front();
}

PegSettings straight(double length_mm, double diameter_mm) {
  return {.from_mm = Vec3::Zero(), .to_mm = {0, 0, -length_mm}, .diameter_mm = diameter_mm};
}

TEST(Pegs, TheSideOfABlock) {
  for (const double edge : {20.0, 19.1, 18.3, 17.7}) {
    Block block({40, 40, 24}, kVoxel, 1.8);
    carve(block, above_plane({edge, 0, 0}, Vec3::UnitX()));
    block.ream(above_plane({0, 0, -3}, Vec3::UnitZ()));
    const PegWall found = peg_in(block, straight(8, 4), 13);
    ASSERT_TRUE(found.least_wall_mm);
    EXPECT_NEAR(*found.least_wall_mm, edge - 13 - 2, kTenthVoxel) << "edge " << edge;
    EXPECT_NEAR(found.length_mm, 8, kTenthVoxel);
    EXPECT_NEAR(found.in_bone_mm, 8, kTenthVoxel);
    EXPECT_EQ(found.perforated_mm, 0);
  }
}

TEST(Pegs, AnInclinedSide) {
  // The side leans over the peg: the wall is thinnest beside the hemisphere at its end.
  const double lean = 25 * kDegree;
  Block block({40, 40, 24}, kVoxel, 1.8);
  const Vec3 outward(std::cos(lean), 0, -std::sin(lean));
  carve(block, above_plane({11, 0, -3}, outward));
  block.ream(above_plane({0, 0, -3}, Vec3::UnitZ()));
  const PegWall found = peg_in(block, straight(9, 4));
  const double from_axis = (Vec3(11, 0, -3) - Vec3(0, 0, -12)).dot(outward);
  ASSERT_TRUE(found.least_wall_mm);
  EXPECT_NEAR(*found.least_wall_mm, from_axis - 2, kTenthVoxel);
}

TEST(Pegs, ASideThatWidensBelowTheFace) {
  // The wall is thinnest at the edge of the face; the voxel under it is left out.
  const double lean = 25 * kDegree;
  Block block({60, 40, 24}, kVoxel, 1.8);
  carve(block, above_plane({11, 0, -3}, {std::cos(lean), 0, std::sin(lean)}));
  block.ream(above_plane({0, 0, -3}, Vec3::UnitZ()));
  const PegWall found = peg_in(block, straight(6, 4));
  EXPECT_GT(found.least_wall_mm.value_or(-1), 11 - 2 - kTenthVoxel);
  EXPECT_LT(found.least_wall_mm.value_or(-1), 11 - 2 + kVoxel * std::tan(lean) + kTenthVoxel);
}

TEST(Pegs, TheFarSideOfABlock) {
  const PegWall found = peg_in(flat_block({40, 40, 18}, 3), straight(12, 5));
  ASSERT_TRUE(found.least_wall_mm);
  EXPECT_NEAR(*found.least_wall_mm, 15 - 12 - 2.5, kTenthVoxel);
}

TEST(Pegs, InABall) {
  const Vec3 center(0, 0, -20);
  Block block({40, 40, 40}, kVoxel, 1.8);
  const Solid inside = ball(center, 18);
  carve(block, [=](const Vec3& p) { return -inside(p); });
  block.ream(above_plane({0, 0, -6}, Vec3::UnitZ()));
  for (const Vec3& to : {Vec3(5, 3, -20), Vec3(-6, 2, -24), Vec3(0, 0, -27)}) {
    const PegSettings peg{.from_mm = {0, 0, 0}, .to_mm = to, .diameter_mm = 4};
    const PegWall found = peg_in(block, peg);
    const double tip_mm = (Vec3(0, 0, -6) + to - center).norm();  // the end lies further from the centre than the rest
    ASSERT_TRUE(found.least_wall_mm);
    EXPECT_NEAR(*found.least_wall_mm, 18 - tip_mm - 2, kTenthVoxel) << to.transpose();
  }
}

TEST(Pegs, AnEndOutsideIsAPerforation) {
  const Block slab = flat_block({40, 40, 9}, 3);
  const Planning found =
      plan(slab, pegged(straight(5, 4)));  // the axis ends 1 mm above the far side, the hemisphere 1 mm below it
  EXPECT_EQ(found.pegs.at(0).perforated_mm, 0);
  EXPECT_EQ(found.pegs_perforated(), 1);
  EXPECT_EQ(plan(slab, pegged(straight(3, 4))).pegs_perforated(), 0);
}

TEST(Pegs, ThroughASlab) {
  const Block slab = flat_block({40, 40, 9}, 3);
  const PegWall found = peg_in(slab, straight(10, 4));
  EXPECT_NEAR(found.length_mm, 10, kTenthVoxel);
  EXPECT_NEAR(found.in_bone_mm, 6, kTenthVoxel);
  EXPECT_NEAR(found.perforated_mm, 4, kTenthVoxel);
  EXPECT_EQ(found.least_wall_mm, 0.0);
}

TEST(Pegs, ObliquelyThroughASlab) {
  const double tilt = 20 * kDegree;
  const Block slab = flat_block({40, 40, 9}, 3);
  const PegSettings peg{
      .from_mm = Vec3::Zero(), .to_mm = 10 * Vec3(std::sin(tilt), 0, -std::cos(tilt)), .diameter_mm = 4};
  const PegWall found = peg_in(slab, peg);
  // The lower side of the circumference leaves the slab first; its upper side enters last.
  const double leaves = (6 - 2 * std::sin(tilt)) / std::cos(tilt);
  const double enters = 2 * std::tan(tilt);
  EXPECT_NEAR(found.perforated_mm, 10 - leaves, kTenthVoxel);
  EXPECT_NEAR(found.in_bone_mm, leaves - enters, 2 * kTenthVoxel);
}

TEST(Pegs, AHollowUnderTheImplantIsNoPerforation) {
  Block block({40, 40, 9}, kVoxel, 1.8);
  carve(block, both(above_plane({0, 0, -5}, Vec3::UnitZ()), rod({0, 0, 0}, Vec3::UnitZ(), 4)));
  block.ream(above_plane({0, 0, -3}, Vec3::UnitZ()));
  const PegWall found = peg_in(block, straight(4, 3));
  EXPECT_NEAR(found.length_mm, 4, kTenthVoxel);
  EXPECT_NEAR(found.in_bone_mm, 2, kTenthVoxel);
  EXPECT_EQ(found.perforated_mm, 0);
  EXPECT_NEAR(found.least_wall_mm.value_or(-1), 2 - 1.5, kTenthVoxel);
}

TEST(Pegs, APilotHoleBelongsToThePeg) {
  Block block({40, 40, 18}, kVoxel, 1.8);
  carve(block, both(above_plane({0, 0, -12}, Vec3::UnitZ()), rod({0, 0, 0}, Vec3::UnitZ(), 1.25)));
  block.ream(above_plane({0, 0, -3}, Vec3::UnitZ()));
  const PegWall found = peg_in(block, straight(10, 5));
  EXPECT_EQ(found.perforated_mm, 0);
  EXPECT_NEAR(found.in_bone_mm, 10, kTenthVoxel);
  EXPECT_NEAR(found.least_wall_mm.value_or(-1), 15 - 10 - 2.5, kTenthVoxel);
}

TEST(Pegs, AKeelBelowTheBack) {
  // A capsule along y, wholly inside the bone: its ends are nearest to the sides.
  const Block block = flat_block({40, 20, 18}, 3);
  const PegWall found = peg_in(block, {.from_mm = {0, -5, -6}, .to_mm = {0, 6, -6}, .diameter_mm = 3});
  EXPECT_NEAR(found.length_mm, 11, kTenthVoxel);
  EXPECT_NEAR(found.in_bone_mm, 11, kTenthVoxel);
  EXPECT_NEAR(found.least_wall_mm.value_or(-1), 10 - 6 - 1.5, kTenthVoxel);
}

TEST(Pegs, OutsideTheBone) {
  const Block block = flat_block({40, 40, 9}, 3);
  const PegWall above = peg_in(block, {.from_mm = {0, 0, 2}, .to_mm = {0, 0, 6}, .diameter_mm = 3});
  EXPECT_EQ(above.length_mm, 0);
  EXPECT_FALSE(above.least_wall_mm);
  const PegWall beside = peg_in(block, {.from_mm = {60, 0, -1}, .to_mm = {60, 0, -5}, .diameter_mm = 3});
  EXPECT_NEAR(beside.perforated_mm, 4, 1e-9);
  EXPECT_EQ(beside.least_wall_mm, 0.0);
}

TEST(Pegs, OfATiltedImplantAreTiltedWithIt) {
  const double tilt = 10 * kDegree;
  const Block block = flat_block({40, 40, 24}, 3);
  ImplantSettings implant = pegged(straight(9, 4));
  implant.axis = {std::sin(tilt), 0, std::cos(tilt)};
  implant.center_mm = {-8, 0, 0};
  const Planning found = plan(block, implant);
  const Vec3 tip = found.bone_from_implant * Vec3(0, 0, -9);
  EXPECT_NEAR(found.pegs.at(0).least_wall_mm.value_or(-1), tip.x() + 20 - 2, kTenthVoxel);
}

}  // namespace
}  // namespace reamsim::test
