// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The envelope of revolution: generating polygons come back, and a toothed mesh sweeps what its teeth reach.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/base/error.h"
#include "sim/tool/profile.h"
#include "tests/tool/reamer_files.h"

namespace reamsim::test {
namespace {

/// Largest distance from a vertex of either profile to the other; for polygons that agree in shape.
double mismatch_mm(const Profile& a, const Profile& b) {
  double worst = 0;
  for (const Vec2& p : a.points) worst = std::max(worst, std::abs(b.nearest(p).distance_mm));
  for (const Vec2& p : b.points) worst = std::max(worst, std::abs(a.nearest(p).distance_mm));
  return worst;
}

/// A box from `low` to `high`, facing outwards.
TriangleMesh box(const Vec3& low, const Vec3& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.emplace_back((i & 1) ? high.x() : low.x(), (i & 2) ? high.y() : low.y(),
                               (i & 4) ? high.z() : low.z());
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

const Profile kCup{{{0, 5}, {4, 5}, {4, 0}, {6, 0}, {6, 8}, {0, 8}}};
const Profile kTube{{{1.25, 0}, {6, 0}, {7, 3}, {2, 9}, {1.25, 9}}};

TEST(Generatrix, ComesBackInOrder) {
  for (const Profile& made : {kCup, kTube}) {
    const auto found = recover_generatrix(revolve(made, 180));
    ASSERT_TRUE(found);
    ASSERT_EQ(found->points.size(), made.points.size());
    EXPECT_LT(mismatch_mm(*found, made), 1e-9);
    EXPECT_GT(signed_area(found->points), 0) << "inside to the left";
  }
}

TEST(Generatrix, OfAShippedReamerIsAccurateToAMicrometre) {
  const auto found = recover_generatrix(reamer("convex"));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->points.size(), 27u);
  int on_face = 0;
  for (const Vec2& p : found->points) {
    if (p.y() > 4.19) continue;
    ++on_face;
    EXPECT_NEAR((p - Vec2(0, 29)).norm(), 29, 1e-6);
  }
  EXPECT_EQ(on_face, 19);
}

TEST(Generatrix, OfAnythingElseIsNone) {
  EXPECT_FALSE(recover_generatrix(box({-5, -5, 0}, {5, 5, 3})));
  EXPECT_FALSE(recover_generatrix(reamer("convex_edges")));
  EXPECT_FALSE(recover_generatrix(revolve(kTube, 12))) << "twelve facets are no circle";
  TriangleMesh shifted = revolve(kTube, 180);
  for (Vec3& p : shifted.vertices) p.x() += 0.1;
  EXPECT_FALSE(recover_generatrix(shifted));
}

TEST(SweepOutline, OfASurfaceOfRevolutionIsItsGeneratingPolygon) {
  for (const Profile& made : {kCup, kTube}) {
    const Profile outline = sweep_outline(revolve(made, 180), 0.02);
    // The bore's facets reach 0.2 µm inwards; the rest is the simplification.
    EXPECT_LT(mismatch_mm(outline, made), 0.005);
    EXPECT_EQ(outline.points.size(), made.points.size());
    EXPECT_NEAR(outline.volume_mm3() / made.volume_mm3(), 1, 5e-4);
  }
  EXPECT_LT(mismatch_mm(sweep_outline(reamer("hemispherical"), 0.02), *recover_generatrix(reamer("hemispherical"))),
            0.005);
}

TEST(SweepOutline, OfABoxIsTheCylinderThroughItsEdges) {
  const Profile outline = sweep_outline(box({-3, -4, 1}, {3, 4, 3}), 0.02);
  const Profile cylinder{{{0, 1}, {5, 1}, {5, 3}, {0, 3}}};
  EXPECT_LT(mismatch_mm(outline, cylinder), 0.005);
  EXPECT_NEAR(outline.volume_mm3(), std::numbers::pi * 25 * 2, 0.1);
}

TEST(SweepOutline, OfABarBesideTheAxisIsATube) {
  const Profile outline = sweep_outline(box({2, -1, 0}, {6, 1, 3}), 0.02);
  const double outer = std::hypot(6, 1);
  const Profile tube{{{2, 0}, {outer, 0}, {outer, 3}, {2, 3}}};
  EXPECT_LT(mismatch_mm(outline, tube), 0.005);
}

TEST(SweepOutline, OfSeparateBodiesIsAnError) {
  TriangleMesh two = box({-1, -1, 0}, {1, 1, 1});
  const TriangleMesh other = box({-1, -1, 3}, {1, 1, 4});
  for (const auto& t : other.triangles) two.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  two.vertices.insert(two.vertices.end(), other.vertices.begin(), other.vertices.end());
  EXPECT_THROW(sweep_outline(two, 0.02), InputError);
}

/// `outer` with `inner` taken out of its inside.
TriangleMesh hollowed(TriangleMesh outer, const TriangleMesh& inner) {
  const auto first = static_cast<std::int32_t>(outer.vertices.size());
  for (const auto& t : inner.triangles) outer.triangles.push_back({t[0] + first, t[2] + first, t[1] + first});
  outer.vertices.insert(outer.vertices.end(), inner.vertices.begin(), inner.vertices.end());
  return outer;
}

TEST(SweepOutline, FillsHollowsThatNothingCanReach) {
  const TriangleMesh ring = revolve({{{2, 4}, {4, 4}, {4, 6}, {2, 6}}}, 180);
  const Profile outline = sweep_outline(hollowed(box({-5, -5, 0}, {5, 5, 10}), ring), 0.02);
  EXPECT_NEAR(outline.volume_mm3(), std::numbers::pi * 50 * 10, 0.5);
}

TEST(SweepOutline, KeepsAHollowOnTheAxis) {
  const TriangleMesh mesh = hollowed(box({-5, -5, 0}, {5, 5, 10}), box({-2, -2, 4}, {2, 2, 6}));
  EXPECT_NEAR(sweep_outline(mesh, 0.02).volume_mm3(), std::numbers::pi * (50 * 10 - 4 * 2), 0.5);
}

TEST(Envelope, OfTheLipsIsTheConvexReamer) {
  const Envelope toothed = envelope_of_revolution(reamer("convex_edges"));
  const Envelope convex = envelope_of_revolution(reamer("convex"));
  EXPECT_TRUE(convex.revolved);
  EXPECT_FALSE(toothed.revolved);
  EXPECT_LT(mismatch_mm(toothed.profile, convex.profile), 0.02);
  for (const Vec2& p : toothed.profile.points)
    if (p.y() < 4.15) {
      EXPECT_NEAR((p - Vec2(0, 29)).norm(), 29, 0.02) << "the face of the envelope is the sphere";
    }
  RecordProperty("mismatch_um", static_cast<int>(1000 * mismatch_mm(toothed.profile, convex.profile)));
}

TEST(Polyline, SimplifyKeepsWithinTolerance) {
  std::vector<Vec2> circle;
  for (int i = 0; i < 2000; ++i) {
    const double a = 2 * std::numbers::pi * i / 2000;
    circle.emplace_back(20 + 5 * std::cos(a), 5 * std::sin(a));
  }
  const Profile simple{simplify(circle, 0.01)};
  EXPECT_LT(simple.points.size(), 150u);
  for (const Vec2& p : circle) EXPECT_LT(std::abs(simple.nearest(p).distance_mm), 0.01 + 1e-9);
}

TEST(Polyline, SharpenRestoresACutCornerOnly) {
  const std::vector<Vec2> cut{{1, 0}, {4.99, 0}, {5, 0.01}, {5, 2}, {4, 3}, {1, 3}};
  const auto sharp = sharpen_corners(cut, 0.02);
  ASSERT_EQ(sharp.size(), 5u);
  EXPECT_NEAR((sharp[1] - Vec2(5, 0)).norm(), 0, 1e-12);
  EXPECT_EQ(sharp[3], Vec2(4, 3)) << "a real chamfer stays";
}

}  // namespace
}  // namespace reamsim::test
