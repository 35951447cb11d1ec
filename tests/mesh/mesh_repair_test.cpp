// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include "sim/mesh/mesh_check.h"
#include "tests/support/mesh_shapes.h"

namespace reamsim::test {
namespace {

/// Cleans a mesh, and closes its holes where it can be oriented.
RepairResult repair(TriangleMesh& mesh) {
  RepairResult done = clean(mesh);
  if (diagnose(mesh).inconsistent_edges == 0) close_holes(mesh, holes_of(mesh), done);
  return done;
}

TEST(MeshRepair, ClosesAHoleTheRightWayRound) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {2, 3, 4});
  mesh.triangles.erase(mesh.triangles.begin() + 2, mesh.triangles.begin() + 4);  // the whole face z = 4
  const RepairResult done = repair(mesh);
  EXPECT_EQ(done.closed_holes, 1U);
  EXPECT_EQ(done.added_triangles, 4U);
  EXPECT_NEAR(done.widest_hole_mm, std::hypot(2, 3), 1e-9);
  const MeshDiagnosis found = diagnose(mesh);
  EXPECT_TRUE(found.closed_manifold()) << found.text();
  EXPECT_NEAR(found.volume_mm3, 24, 1e-9);
}

TEST(MeshRepair, ClosesTwoHolesApart) {
  TriangleMesh mesh = sphere_mesh({0, 0, 0}, 10, 3);
  const double before = mesh.volume_mm3();
  mesh.triangles.erase(mesh.triangles.begin());
  mesh.triangles.pop_back();
  EXPECT_EQ(repair(mesh).closed_holes, 2U);
  EXPECT_TRUE(diagnose(mesh).closed_manifold());
  EXPECT_NEAR(mesh.volume_mm3(), before, 0.01 * before);
}

TEST(MeshRepair, DropsRepeatedAndCollapsedTriangles) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  const auto& [a, b, c] = mesh.triangles[0];
  mesh.triangles.insert(mesh.triangles.end(), {{b, c, a}, {a, a, c}});
  EXPECT_EQ(repair(mesh).dropped_triangles, 2U);
  EXPECT_EQ(mesh.triangles.size(), 12U);
  EXPECT_TRUE(diagnose(mesh).closed_manifold());
}

TEST(MeshRepair, TurnsTheMinorityOfEachSurface) {
  TriangleMesh mesh = sphere_mesh({0, 0, 0}, 10, 2);
  const std::vector<std::array<std::int32_t, 3>> right = mesh.triangles;
  for (const std::size_t i : {0U, 7U, 8U, 100U}) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
  EXPECT_EQ(repair(mesh).turned_triangles, 4U);
  EXPECT_TRUE(diagnose(mesh).closed_manifold());
  EXPECT_NEAR(mesh.volume_mm3(), sphere_mesh({0, 0, 0}, 10, 2).volume_mm3(), 1e-9);
}

TEST(MeshRepair, ASurfaceWithOneSideStaysSo) {
  TriangleMesh strip;  // a Moebius strip of five quadrilaterals
  strip.vertices.assign(10, Vec3::Zero());
  for (std::int32_t i = 0; i < 5; ++i) {
    const std::int32_t a = 2 * i, b = a + 1, c = i < 4 ? a + 2 : 1, d = i < 4 ? a + 3 : 0;
    strip.triangles.insert(strip.triangles.end(), {{a, c, b}, {b, c, d}});
  }
  repair(strip);
  EXPECT_GT(diagnose(strip).inconsistent_edges, 0U);
}

TEST(MeshRepair, LeavesAGoodMeshAlone) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  const RepairResult done = repair(mesh);
  EXPECT_EQ(done.closed_holes + done.dropped_triangles + done.added_triangles, 0U);
  EXPECT_EQ(mesh.triangles, box_mesh({0, 0, 0}, {1, 1, 1}).triangles);
}

}  // namespace
}  // namespace reamsim::test
