// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The tool's outline of lines and arcs, which exact erosion clips voxels by.
#include <iostream>

#include "kernels/clip.h"
#include "sim/engine/common/tables.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::outline_tests {
namespace {

constexpr double kRadius = 29, kHalf = 18, kTop = 9, kBore = 1.25;

Profile cap() {
  return cap_profile(kRadius, 2 * kHalf, kTop, kBore);
}

double from_segment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const double t = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - t * (b - a)).norm();
}

/// Signed distance of cap(), the sphere itself and not its edges, mm.
double from_cap(const Vec2& p) {
  const auto low = [](double r) { return kRadius - std::sqrt(kRadius * kRadius - r * r); };
  const Vec2 center(0, kRadius), inner(kBore, low(kBore)), outer(kHalf, low(kHalf));
  double away = std::min({from_segment(p, outer, {kHalf, kTop}), from_segment(p, {kHalf, kTop}, {kBore, kTop}),
                          from_segment(p, {kBore, kTop}, inner)});
  const Vec2 foot = center + kRadius * (p - center).normalized();
  if (foot.y() < kRadius && foot.x() >= kBore && foot.x() <= kHalf) away = std::min(away, (p - foot).norm());
  const bool inside = p.x() > kBore && p.x() < kHalf && p.y() < kTop && p.y() > low(p.x());
  return inside ? -away : away;
}

TEST(Outline, OfACapIsAnArcAndThreeLines) {
  const Outline outline = fit_outline(cap());
  ASSERT_EQ(outline.arcs.size(), 4U);
  EXPECT_NEAR(outline.arcs[0].curvature, 1 / kRadius, 1e-9);
  for (int i = 1; i < 4; ++i) EXPECT_EQ(outline.arcs[static_cast<std::size_t>(i)].curvature, 0);
  const double edge = (kHalf - kBore) / 48 / std::sqrt(1 - kHalf * kHalf / kRadius / kRadius);
  EXPECT_NEAR(outline.bulge_mm, edge * edge / 8 / kRadius, 1e-3);
  // Whole balls too, from pole to pole, where the axis closes the outline: no arc is longer than 100 degrees.
  Profile ball;
  for (int i = 0; i <= 90; ++i)
    ball.points.emplace_back(i % 90 == 0 ? 0 : std::sin(M_PI * i / 90), -std::cos(M_PI * i / 90));
  const Outline half = fit_outline(ball);
  ASSERT_EQ(half.arcs.size(), 2U);
  EXPECT_NEAR(half.arcs[0].length() + half.arcs[1].length(), M_PI, 1e-9);
}

TEST(Outline, WhatLiesOnNoCircleStaysLines) {
  Profile zigzag;
  for (int i = 0; i < 40; ++i) zigzag.points.emplace_back(1 + 0.1 * i, i % 2 == 0 ? 0 : 0.008);
  zigzag.points.emplace_back(4.9, 3);
  zigzag.points.emplace_back(1, 3);
  const Outline outline = fit_outline(zigzag);
  EXPECT_EQ(outline.arcs.size(), zigzag.points.size());
  EXPECT_EQ(outline.bulge_mm, 0);
}

TEST(Outline, DistancesAndNormalsAreThoseOfTheCap) {
  const OutlineTable table = full_outline_table(cap(), 0.25);
  const OutlineView view = view_of(table);
  double worst = 0, worst_normal = 0;
  for (int i = 1; i < 600; ++i) {
    for (int k = 0; k < 600; ++k) {
      const float r = static_cast<float>(24.0 * i / 600), z = static_cast<float>(24.0 * (k - 200) / 600);
      const double expected = from_cap({r, z});
      const NearestPiece found = rs_outline_nearest(&view, view.lists[0], r, z);
      worst = std::max(worst, std::abs(found.distance - expected));
      // The normal is the distance's gradient, but where two pieces are as near.
      const double h = 1e-4;
      const Vec2 gradient((from_cap({r + h, z}) - from_cap({r - h, z})) / (2 * h),
                          (from_cap({r, z + h}) - from_cap({r, z - h})) / (2 * h));
      if (std::abs(gradient.norm() - 1) > 1e-3 || std::abs(expected) < 2 * h) continue;
      worst_normal = std::max(worst_normal, (gradient - Vec2(found.normal_r, found.normal_z)).norm());
    }
  }
  std::cout << "distances off by up to " << worst << " mm, normals by " << worst_normal << '\n';
  EXPECT_LT(worst, 2e-5);
  EXPECT_LT(worst_normal, 1e-2);
}

TEST(Outline, ListsGiveTheDistancesOfTheWhole) {
  constexpr unsigned kSeed = 77;
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(0, 1);
  const Profile profile = cap();
  for (const double voxel_mm : {0.05, 0.25, 1.0}) {
    const OutlineTable full = full_outline_table(profile, voxel_mm), table = make_outline_table(profile, voxel_mm);
    const OutlineView all = view_of(full), some = view_of(table);
    for (int i = 0; i < 20000; ++i) {
      const auto edge = static_cast<std::size_t>(random() % profile.points.size());
      const Vec2 a = profile.points[edge], b = profile.points[(edge + 1) % profile.points.size()];
      const Vec2 near = a + u(random) * (b - a) + 2 * voxel_mm * Vec2(u(random) - 0.5, u(random) - 0.5);
      const double turn = 2 * M_PI * u(random), away = 6.06 * voxel_mm * u(random);
      const Vec2 center = near + away * Vec2(std::cos(turn), std::sin(turn));
      const auto r = static_cast<float>(std::abs(near.x())), z = static_cast<float>(near.y());
      const NearestPiece expected = rs_outline_nearest(&all, all.lists[0], r, z);
      const PieceList list =
          rs_pieces_near(&some, static_cast<float>(std::abs(center.x())), static_cast<float>(center.y()));
      const NearestPiece found = rs_outline_nearest(&some, list, r, z);
      ASSERT_EQ(found.distance, expected.distance) << near.transpose();
      ASSERT_EQ(found.normal_r, expected.normal_r) << near.transpose();
      ASSERT_EQ(found.normal_z, expected.normal_z) << near.transpose();
      ASSERT_EQ(found.piece, expected.piece) << near.transpose();
    }
  }
}

TEST(Outline, MarksSharpCornersBetweenLinesAsLongAsAVoxel) {
  // A flat reamer whose rim is chamfered by 0.1 mm: in voxels of 0.5 mm three planes would meet.
  const Profile chamfered{{{2, 0}, {9.9, 0}, {10, 0.1}, {10, 4}, {2, 4}}};
  const auto corners = [&](double voxel_mm) {
    int count = 0;
    for (const OutlinePiece& piece : full_outline_table(chamfered, voxel_mm).pieces) count += piece.after >= 0 ? 1 : 0;
    return count;
  };
  EXPECT_EQ(corners(0.5), 3);
  EXPECT_EQ(corners(0.05), 5);
}

ClipPlane plane(const Vec3& n, double away) {
  return {{static_cast<float>(n.x()), static_cast<float>(n.y()), static_cast<float>(n.z())},
          static_cast<float>(away),
          static_cast<float>(n.z())};
}

/// The part of a unit cube outside a corner by counting points.
double counted_corner(const ClipPlane& a, const ClipPlane& b, bool bulges) {
  constexpr int kPerAxis = 50;
  int outside = 0;
  for (int i = 0; i < kPerAxis * kPerAxis * kPerAxis; ++i) {
    const auto at = [](int k) { return static_cast<float>((k + 0.5) / kPerAxis - 0.5); };
    const float x = at(i % kPerAxis), y = at(i / kPerAxis % kPerAxis), z = at(i / kPerAxis / kPerAxis);
    const bool beyond_a = a.away + a.n[0] * x + a.n[1] * y + a.n[2] * z > 0;
    const bool beyond_b = b.away + b.n[0] * x + b.n[1] * y + b.n[2] * z > 0;
    outside += (bulges ? beyond_a || beyond_b : beyond_a && beyond_b) ? 1 : 0;
  }
  return outside / std::pow(kPerAxis, 3);
}

TEST(Clip, CornersAgreeWithCountingPoints) {
  constexpr unsigned kSeed = 815;
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> u(-0.6, 0.6);
  double sum = 0, worst = 0;
  constexpr int kTimes = 600;
  for (int i = 0; i < kTimes; ++i) {
    Vec3 n(gauss(random), gauss(random), gauss(random)), m(gauss(random), gauss(random), gauss(random));
    if (i % 4 == 0) {  // along the lattice
      n = Vec3::Unit(i / 4 % 3);
      m = -Vec3::Unit((i / 4 + 1) % 3);
    }
    Clip clip{};
    clip.plane = plane(n.normalized(), u(random));
    clip.other = plane(m.normalized(), u(random));
    clip.corner = i % 2 == 0 ? 1.0F : -1.0F;
    const double error = rs_clip_fractions(&clip).tool - counted_corner(clip.plane, clip.other, clip.corner > 0);
    sum += error * error;
    worst = std::max(worst, std::abs(error));
  }
  std::cout << "RMS " << std::sqrt(sum / kTimes) << ", worst " << worst << '\n';
  EXPECT_LT(std::sqrt(sum / kTimes), 0.006);
  EXPECT_LT(worst, 0.02);
}

TEST(Clip, OnTheAxisABoresWallHasADirection) {
  const OutlineTable table = full_outline_table(cap_profile(29, 36, 9, 0.4), 1.0);
  const OutlineView outline = view_of(table);
  SubstepArgs args{};
  args.voxel_mm = args.per_voxel_mm = 1;
  for (int i = 0; i < 3; ++i) args.tool_step[4 * i] = args.lattice_from_tool[4 * i] = 1;
  const BrickMiddle brick = {{0, 0, 4}, {0, 0, 0}};
  const Clip clip =
      rs_clip(&args, &outline, outline.lists[0], &brick, RS_BRICK_MIDDLE, RS_BRICK_MIDDLE, RS_BRICK_MIDDLE);
  EXPECT_FLOAT_EQ(clip.distance, 0.4F);
  EXPECT_NEAR(rs_clip_fractions(&clip).tool, 0.9, 1e-6);
}

TEST(Clip, WhereOnePlaneOfACornerMattersItAloneDecides) {
  Clip clip{};
  clip.corner = 1;
  clip.plane = plane({0, 0, -1}, 0.2);
  clip.other = plane({1, 0, 0}, -0.6);  // the cube lies inside it
  EXPECT_FLOAT_EQ(rs_clip_fractions(&clip).tool, rs_outside_fraction(clip.plane.n, clip.plane.away));
  clip.other = plane({1, 0, 0}, 0.6);  // or outside, and then outside the tool
  EXPECT_EQ(rs_clip_fractions(&clip).tool, 1);
  clip.corner = -1;
  EXPECT_FLOAT_EQ(rs_clip_fractions(&clip).tool, rs_outside_fraction(clip.plane.n, clip.plane.away));
}

}  // namespace
}  // namespace reamsim::test::outline_tests
