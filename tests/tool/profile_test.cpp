// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Signed distance, normal and volume of a profile against shapes with closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "sim/tool/profile.h"

namespace reamsim {
namespace {

Profile cylinder(double radius, double height) {
  return {{{0, 0}, {radius, 0}, {radius, height}, {0, height}}};
}

Profile tube(double inner, double outer, double height) {
  return {{{inner, 0}, {outer, 0}, {outer, height}, {inner, height}}};
}

/// Half circle about (0, 0) by chords, from the lower pole to the upper one.
Profile sphere(double radius, int edges) {
  Profile profile;
  for (int i = 0; i <= edges; ++i) {
    const double angle = -std::numbers::pi / 2 + std::numbers::pi * i / edges;
    profile.points.emplace_back(i == 0 || i == edges ? 0.0 : radius * std::cos(angle), radius * std::sin(angle));
  }
  return profile;
}

TEST(Profile, DistanceToACylinderIsExact) {
  const Profile p = cylinder(5, 10);
  const auto expect = [&](const Vec2& at, double distance, const Vec2& normal) {
    const auto n = p.nearest(at);
    EXPECT_NEAR(n.distance_mm, distance, 1e-12) << at.transpose();
    EXPECT_NEAR((n.normal - normal).norm(), 0, 1e-12) << at.transpose() << " gave " << n.normal.transpose();
  };
  expect({7, 5}, 2, {1, 0});
  expect({4, 5}, -1, {1, 0});
  expect({1, -3}, 3, {0, -1});
  expect({1, 9}, -1, {0, 1});
  expect({5, 5}, 0, {1, 0});
  expect({8, 14}, 5, {0.6, 0.8});
  expect({8, -4}, 5, {0.6, -0.8});
}

TEST(Profile, TheAxisIsNoSurface) {
  const auto n = cylinder(5, 100).nearest({0.001, 50});
  EXPECT_NEAR(n.distance_mm, -4.999, 1e-12);
  EXPECT_NEAR(n.normal.x(), 1, 1e-12);
}

TEST(Profile, ABoreIsOutside) {
  const Profile p = tube(1, 5, 10);
  EXPECT_NEAR(p.nearest({0.25, 5}).distance_mm, 0.75, 1e-12);
  EXPECT_NEAR(p.nearest({0.25, 5}).normal.x(), -1, 1e-12);
  EXPECT_NEAR(p.nearest({1.5, 5}).distance_mm, -0.5, 1e-12);
}

/// Whether a vertical ray from the point upwards meets the polygon an odd number of times.
bool is_inside(const Profile& profile, const Vec2& at) {
  bool inside = false;
  for (std::size_t i = 0; i < profile.points.size(); ++i) {
    const Vec2 &a = profile.points[i], &b = profile.points[(i + 1) % profile.points.size()];
    if ((a.x() > at.x()) == (b.x() > at.x())) continue;
    inside ^= a.y() + (at.x() - a.x()) / (b.x() - a.x()) * (b.y() - a.y()) > at.y();
  }
  return inside;
}

TEST(Profile, TheSignIsRightBeyondCornersWhateverTheirRounding) {
  constexpr unsigned kSeed = 20261124;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> scale(0.1, 3), r(0, 40), z(-40, 60);
  for (int tool = 0; tool < 50; ++tool) {
    // A disc with a rim and a hub, with sharp and blunt corners.
    Profile p{{{1.25, 0.03}, {7.1, 0.9}, {15, 4.18}, {15, 5.8}, {6.5, 7.3}, {4, 30}, {1.25, 30}}};
    const double factor = scale(random);
    for (Vec2& point : p.points) point *= factor;
    for (int i = 0; i < 2000; ++i) {
      const Vec2 at(r(random), z(random));
      const double mm = p.nearest(at).distance_mm;
      ASSERT_EQ(mm < 0, is_inside(p, at)) << "seed " << kSeed << ", scale " << factor << ", at " << at.transpose();
    }
  }
}

TEST(Profile, DistanceToASphereIsWithinTheChordError) {
  constexpr double kRadius = 12;
  constexpr int kEdges = 400;
  const double chord_error = kRadius * (1 - std::cos(std::numbers::pi / kEdges / 2));
  const Profile p = sphere(kRadius, kEdges);
  std::mt19937 random(20200101);
  std::uniform_real_distribution<double> r(0, 20), z(-20, 20);
  for (int i = 0; i < 500; ++i) {
    const Vec2 at(r(random), z(random));
    const auto n = p.nearest(at);
    EXPECT_NEAR(n.distance_mm, at.norm() - kRadius, chord_error + 1e-9);
    // Far inside, the nearest of many nearly equal chords may be any; near the surface the normal is radial.
    if (std::abs(at.norm() - kRadius) < 3) {
      EXPECT_GT(n.normal.dot(at.normalized()), 0.9999) << at.transpose();
    }
  }
}

TEST(Profile, ANotchedProfileKnowsInsideFromOutsideAtReentrantCorners) {
  // A cup: the inside of it is outside the tool.
  const Profile cup{{{0, 5}, {4, 5}, {4, 0}, {6, 0}, {6, 8}, {0, 8}}};
  EXPECT_NEAR(cup.nearest({2, 4}).distance_mm, 1, 1e-12);
  EXPECT_NEAR(cup.nearest({3.5, 4.5}).distance_mm, 0.5, 1e-12);
  EXPECT_NEAR(cup.nearest({4.5, 5.5}).distance_mm, -std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(cup.nearest({5, 2}).distance_mm, -1, 1e-12);
}

TEST(Profile, VolumeByPappus) {
  EXPECT_NEAR(cylinder(5, 10).volume_mm3(), std::numbers::pi * 250, 1e-9);
  EXPECT_NEAR(tube(1, 5, 10).volume_mm3(), std::numbers::pi * 240, 1e-9);
  EXPECT_NEAR(sphere(12, 2000).volume_mm3(), 4.0 / 3 * std::numbers::pi * 1728, 0.02);
  const Profile cone{{{0, 0}, {3, 7}, {0, 7}}};
  EXPECT_NEAR(cone.volume_mm3(), std::numbers::pi * 9 * 7 / 3, 1e-9);
}

TEST(Profile, LargestRadius) {
  EXPECT_EQ(tube(1, 5, 10).max_radius_mm(), 5);
}

}  // namespace
}  // namespace reamsim
