// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/winding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "sim/mesh/mesh_check.h"
#include "tests/support/mesh_shapes.h"

namespace reamsim::test {
namespace {

TEST(Winding, CountsTheSurfacesRoundAPoint) {
  const TriangleMesh mesh = joined({box_mesh({0, 0, 0}, {10, 10, 10}), box_mesh({5, 5, 5}, {15, 15, 15}),
                                    inside_out(box_mesh({1, 1, 1}, {3, 3, 3}))});
  for (int axis = 0; axis < 3; ++axis) {
    const LineCrossings lines(mesh, axis);
    EXPECT_EQ(lines.winding({4, 4, 4}), 1) << axis;
    EXPECT_EQ(lines.winding({7, 7, 7}), 2) << axis;
    EXPECT_EQ(lines.winding({12, 12, 12}), 1) << axis;
    EXPECT_EQ(lines.winding({2, 2, 2}), 0) << "through edges and corners, axis " << axis;
    EXPECT_EQ(lines.winding({-1, 5, 5}), 0) << axis;
    EXPECT_EQ(lines.winding({20, 5, 5}), 0) << axis;
  }
}

TEST(Winding, TheVolumeOfAnOpenSphereIsThatOfTheClosedOne) {
  TriangleMesh open = sphere_mesh({3, 4, 5}, 10, 4);
  const TriangleMesh closed = open;
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 20);
  const VolumeChange change = compare_volumes(open, closed);
  const double truth_mm3 = closed.volume_mm3();
  EXPECT_NEAR(change.after_mm3, truth_mm3, 0.01 * truth_mm3);
  EXPECT_LT(change.differs_mm3, 0.01 * truth_mm3);
}

TEST(MeshHoles, AreMeasured) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {2, 3, 4});
  mesh.triangles.erase(mesh.triangles.begin() + 2, mesh.triangles.begin() + 4);  // the face z = 4
  const auto holes = holes_of(mesh);
  ASSERT_EQ(holes.size(), 1U);
  EXPECT_NEAR(holes[0].area_mm2, 6, 1e-9);
  EXPECT_NEAR(holes[0].width_mm, 2, 1e-9);
  EXPECT_NEAR(holes[0].length_mm, std::hypot(2, 3), 1e-9);
  RepairResult done;
  close_holes(mesh, holes, done);
  EXPECT_TRUE(diagnose(mesh).closed_manifold());
  EXPECT_NEAR(mesh.volume_mm3(), 24, 1e-9);
  EXPECT_TRUE(holes_of(mesh).empty());
}

TEST(MeshHoles, SmallOnesAndLargeOnes) {
  TriangleMesh mesh = sphere_mesh({0, 0, 0}, 30, 4);
  const double surface = mesh.area_mm2();
  EXPECT_NEAR(surface, 4 * std::numbers::pi * 900, 0.01 * surface);
  mesh.triangles.pop_back();
  EXPECT_TRUE(are_small(holes_of(mesh), surface));
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 16);
  EXPECT_FALSE(are_small(holes_of(mesh), surface)) << "wider than 3 mm";
}

TEST(MeshHoles, AFlapIsAHoleOfItsSize) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  mesh.vertices.emplace_back(0.5, -1, 0);
  mesh.triangles.push_back({0, 1, 8});
  const auto holes = holes_of(mesh);
  ASSERT_EQ(holes.size(), 1U);
  EXPECT_NEAR(holes[0].area_mm2, 0.5, 1e-9);
}

TEST(MeshClean, DoubledFacesOfEitherOrientation) {
  const TriangleMesh sphere = sphere_mesh({0, 0, 0}, 10, 3);
  const auto expect_clean = [&](TriangleMesh mesh, const char* what) {
    clean(mesh);
    turn_outwards(mesh);
    EXPECT_TRUE(diagnose(mesh).closed_manifold()) << what;
    EXPECT_NEAR(mesh.volume_mm3(), sphere.volume_mm3(), 1e-9) << what;
  };
  TriangleMesh mesh = sphere;
  mesh.triangles.insert(mesh.triangles.end(), sphere.triangles.begin(), sphere.triangles.begin() + 100);
  expect_clean(mesh, "some doubled");
  mesh = sphere;
  for (const auto& [a, b, c] : sphere.triangles) mesh.triangles.push_back({a, c, b});
  expect_clean(mesh, "two-sided");
  mesh = sphere;
  for (std::size_t i = 0; i < 100; ++i) {
    const auto [a, b, c] = sphere.triangles[i];
    mesh.triangles.push_back({a, c, b});
  }
  expect_clean(mesh, "partly two-sided");
  mesh = sphere;
  mesh.vertices.emplace_back(20, 0, 0);
  const auto flap = static_cast<std::int32_t>(mesh.vertices.size() - 1);
  const auto [a, b, c] = sphere.triangles[0];
  mesh.triangles.insert(mesh.triangles.end(), {{a, b, flap}, {b, a, flap}});
  expect_clean(mesh, "a two-sided flap");
}

}  // namespace
}  // namespace reamsim::test
