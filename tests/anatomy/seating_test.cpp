// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/anatomy/implant_fixture.h"

namespace reamsim::test {
namespace {

constexpr double kRadius = 29;
constexpr double kRim = 12;  // of the face, mm

MetricSettings with_implant(double radius, double diameter = 0, double gap = 0.5) {
  MetricSettings settings;
  settings.implant = ImplantSettings{.backside_radius_mm = radius, .diameter_mm = diameter, .gap_mm = gap};
  return settings;
}

/// A spherical face of radius 29 out to 12 mm from the axis, 5 mm deep.
Block spherical_face() {
  Block block({40, 40, 9}, kVoxel, 1.8);
  block.ream(both(cap({0, 0, -5}, kRadius), rod({0, 0, 0}, Vec3::UnitZ(), kRim)));
  return block;
}

TEST(Seating, MatchingRadiusSeatsEverywhere) {
  const auto found = spherical_face().measure(Rigid::Identity(), with_implant(kRadius)).planning;
  ASSERT_TRUE(found);
  EXPECT_EQ(found->seating.seated_percent, 100);
  EXPECT_LT(found->seating.max_gap_mm, 0.05);
  // Columns within two voxels of the wall belong to no face.
  EXPECT_NEAR(found->seating.footprint_mm2, kPi * 11 * 11, 30);
}

TEST(Seating, ASmallerRadiusTouchesInTheMiddle) {
  const double radius = 20;
  const double gap = 0.3;
  const auto found = spherical_face().measure(Rigid::Identity(), with_implant(radius, 20, gap)).planning;
  ASSERT_TRUE(found);
  // The innermost hundredth of the area gives way, r = R/10; from there gap(r) grows with the sagittas' difference.
  const auto difference = [&](double r) { return sagitta(radius, r) - sagitta(kRadius, r); };
  double seated_r = 0;
  while (seated_r < 10 && difference(seated_r) - difference(1) <= gap) seated_r += 1e-3;
  EXPECT_NEAR(found->seating.seated_percent, seated_r * seated_r, 1);  // 100·(r/10)²
  EXPECT_NEAR(found->seating.max_gap_mm, difference(10) - difference(1), 0.05);
}

TEST(Seating, AFlatBackRestsOnTheRimOfItsFootprint) {
  const auto found = spherical_face().measure(Rigid::Identity(), with_implant(0, 20, 0.5)).planning;
  ASSERT_TRUE(found);
  const double rest_r = 10 * std::sqrt(0.99);  // the outermost hundredth gives way
  EXPECT_NEAR(found->seating.max_gap_mm, sagitta(kRadius, rest_r), 0.05);
  // Seated where sagitta(r) ≥ sagitta(rest) − 0.5.
  const double least = sagitta(kRadius, rest_r) - 0.5;
  const double inner2 = kRadius * kRadius - (kRadius - least) * (kRadius - least);
  EXPECT_NEAR(found->seating.seated_percent, 100 - inner2, 1);
  EXPECT_NEAR(found->seating.mean_gap_mm, sagitta(kRadius, rest_r) / 2, 0.05);  // the sagitta is nearly linear in r²
}

TEST(Seating, WhatIsNotReamedHoldsItOff) {
  // A flat back wider than the flat recess of 12 mm radius rests on the bone beside it.
  Block block({40, 40, 9}, kVoxel, 1.8);
  block.ream(both(above_plane({0, 0, -3}, Vec3::UnitZ()), rod({0, 0, 0}, Vec3::UnitZ(), kRim)));
  const auto found = block.measure(Rigid::Identity(), with_implant(0, 32)).planning;
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->seating.max_gap_mm, 3, 0.05);
  EXPECT_NEAR(found->seating.seated_percent, 100 * (1 - 144.0 / 256), 1);
  EXPECT_NEAR(found->seating.unreamed_mm2, kPi * (256 - 144), 0.01 * kPi * 256);
  ASSERT_TRUE(found->seating.held_off);
  const HeldOff& held = *found->seating.held_off;
  EXPECT_NEAR(held.gap_mm, 3, 0.05);
  EXPECT_NEAR(held.area_mm2, kPi * (256 - 144), 0.01 * kPi * 256);
  EXPECT_NEAR(held.position_mm.z(), 0, 0.05);
  EXPECT_GT(held.position_mm.head<2>().norm(), kRim);
  EXPECT_NE(found->seating.warning().find("hold the implant off by 3.0"), std::string::npos)
      << found->seating.warning();
  const auto narrow = block.measure(Rigid::Identity(), with_implant(0, 20)).planning;
  ASSERT_TRUE(narrow);
  EXPECT_FALSE(narrow->seating.held_off);
  EXPECT_EQ(narrow->seating.unreamed_mm2, 0);
  EXPECT_EQ(narrow->seating.warning(), "");
}

TEST(Seating, ACoreInTheMiddleDoesNot) {
  Block block({40, 40, 9}, kVoxel, 1.8);
  const Solid bore = rod({0, 0, 0}, Vec3::UnitZ(), 1.25);
  block.ream(without(both(cap({0, 0, -5}, kRadius), rod({0, 0, 0}, Vec3::UnitZ(), kRim)), bore));
  for (const double diameter : {0.0, 20.0}) {
    const auto found = block.measure(Rigid::Identity(), with_implant(kRadius, diameter)).planning;
    ASSERT_TRUE(found);
    EXPECT_EQ(found->seating.seated_percent, 100) << "diameter " << diameter;
    EXPECT_LT(found->seating.max_gap_mm, 0.1) << "diameter " << diameter;
  }
}

TEST(Seating, ATallCoreDoesNot) {
  // Columns beside it keep 98 % of their bone and more, over so long a way that the rest is not negligible. The face
  // was inclined, so that bone was removed above the core as well.
  Block block({26, 26, 10}, kVoxel, 1.8);
  block.ream(above_plane({0, 0, -3}, {std::sin(20 * kDegree), 0, std::cos(20 * kDegree)}));
  block.before = block.after.fill;
  const Solid bore = rod({0.1, 0, 0}, Vec3::UnitZ(), 1.25);
  block.ream(without(both(above_plane({0, 0, -8}, Vec3::UnitZ()), rod({0, 0, 0}, Vec3::UnitZ(), kRim)), bore));
  const auto found = block.measure(Rigid::Identity(), with_implant(0, 16));
  ASSERT_TRUE(found.planning && found.perforation);
  EXPECT_EQ(found.planning->seating.seated_percent, 100);
  EXPECT_LT(found.planning->seating.max_gap_mm, 0.1);
  EXPECT_EQ(found.perforation->holes, 0);
}

TEST(Seating, AHollowThatTheReamerDidNotReachIsAGap) {
  // A hollow 2 mm below the face, 4 mm wide: there before, and untouched.
  Block block({40, 40, 9}, kVoxel, 1.8);
  block.ream(both(above_plane({0, 0, -5}, Vec3::UnitZ()), rod({0, 0, 0}, Vec3::UnitZ(), 4)));
  block.before = block.after.fill;
  block.ream(both(above_plane({0, 0, -3}, Vec3::UnitZ()), rod({0, 0, 0}, Vec3::UnitZ(), kRim)));
  const auto found = block.measure(Rigid::Identity(), with_implant(0, 20)).planning;
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->seating.max_gap_mm, 2, 0.05);
  EXPECT_NEAR(found->seating.seated_percent, 100 * (1 - 16.0 / 100), 1);
}

TEST(Seating, WhereThereIsNoBoneNothingSeats) {
  // The bone ends at x = 5; the footprint reaches to 10.
  Block block({40, 40, 9}, kVoxel, 1.8);
  block.ream([](const Vec3& p) { return 5 - p.x(); });
  block.before = block.after.fill;
  block.ream(both(above_plane({0, 0, -3}, Vec3::UnitZ()), rod({0, 0, 0}, Vec3::UnitZ(), kRim)));
  const auto found = block.measure(Rigid::Identity(), with_implant(0, 20)).planning;
  ASSERT_TRUE(found);
  const double missing = 100 * std::acos(0.5) - 5 * std::sqrt(75.0);  // the segment beyond x = 5
  EXPECT_NEAR(found->seating.seated_percent, 100 * (1 - missing / (100 * kPi)), 1);
}

}  // namespace
}  // namespace reamsim::test
