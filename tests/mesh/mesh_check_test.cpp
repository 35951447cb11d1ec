// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "sim/mesh/mesh_io.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

TEST(MeshCheck, ClosedBox) {
  const MeshDiagnosis found = diagnose(box_mesh({0, 0, 0}, {2, 3, 4}));
  EXPECT_TRUE(found.closed_manifold());
  EXPECT_EQ(found.components, 1U);
  EXPECT_EQ(found.degenerate_triangles, 0U);
  EXPECT_NEAR(found.volume_mm3, 24, 1e-12);
  EXPECT_FALSE(found.first_hole_mm);
}

TEST(MeshCheck, SphereVolume) {
  const TriangleMesh mesh = sphere_mesh({100, -50, 7}, 10, 4);
  EXPECT_EQ(mesh.triangles.size(), 20U * 256);
  EXPECT_TRUE(diagnose(mesh).closed_manifold());
  EXPECT_NEAR(mesh.volume_mm3(), 4.0 / 3 * std::numbers::pi * 1000, 15);
}

TEST(MeshCheck, InsideOutHasNegativeVolume) {
  const MeshDiagnosis found = diagnose(inside_out(box_mesh({0, 0, 0}, {1, 1, 1})));
  EXPECT_TRUE(found.closed_manifold());
  EXPECT_NEAR(found.volume_mm3, -1, 1e-12);
}

TEST(MeshCheck, AMissingTriangleIsAHoleOfThreeEdges) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  mesh.triangles.erase(mesh.triangles.begin() + 2);  // (0,0,1), (1,0,1), (1,1,1)
  const MeshDiagnosis found = diagnose(mesh);
  EXPECT_EQ(found.boundary_edges, 3U);
  EXPECT_FALSE(found.closed_manifold());
  ASSERT_TRUE(found.first_hole_mm);
  EXPECT_NEAR(found.first_hole_mm->z(), 1, 1e-12);
  EXPECT_THAT(found.text(), HasSubstr("3 boundary edges (the first at "));
}

TEST(MeshCheck, AFlippedTriangleIsInconsistent) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  std::swap(mesh.triangles[0][1], mesh.triangles[0][2]);
  const MeshDiagnosis found = diagnose(mesh);
  EXPECT_EQ(found.inconsistent_edges, 3U);
  EXPECT_EQ(found.boundary_edges, 0U);
  EXPECT_FALSE(found.closed_manifold());
}

TEST(MeshCheck, AFinIsNonManifold) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  mesh.vertices.emplace_back(0.5, -1, 0);
  mesh.triangles.push_back({0, 1, 8});
  const MeshDiagnosis found = diagnose(mesh);
  EXPECT_EQ(found.nonmanifold_edges, 1U);
  EXPECT_EQ(found.boundary_edges, 2U);
  ASSERT_TRUE(found.first_nonmanifold_mm);
  EXPECT_NEAR((*found.first_nonmanifold_mm - Vec3(0.5, 0, 0)).norm(), 0, 1e-12);
}

TEST(MeshCheck, CountsDegenerateTrianglesAndPieces) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  const TriangleMesh other = box_mesh({5, 5, 5}, {6, 6, 6});
  for (auto triangle : other.triangles) {
    for (auto& v : triangle) v += 8;
    mesh.triangles.push_back(triangle);
  }
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  mesh.triangles.push_back({3, 3, 7});
  const MeshDiagnosis found = diagnose(mesh);
  EXPECT_EQ(found.components, 2U);
  EXPECT_EQ(found.degenerate_triangles, 1U);
  EXPECT_TRUE(found.closed_manifold());
}

TEST(MeshCheck, RealScapulaIsClosed) {
  const std::string path = data_file("scapula_mesh/scapula_left.stl");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path << "; set REAMSIM_DATA";
  const TriangleMesh mesh = read_mesh(path, 55);
  EXPECT_EQ(mesh.vertices.size(), 7028U);
  EXPECT_EQ(mesh.triangles.size(), 14052U);
  const MeshDiagnosis found = diagnose(mesh);
  EXPECT_TRUE(found.closed_manifold());
  EXPECT_EQ(found.components, 1U);
  EXPECT_NEAR(mesh.bounds().half().z() * 2, 153, 1);
}

TEST(MeshCheck, RealDirtyScapula) {
  const std::string path = data_file("dirty_mesh/scapula_open_nonmanifold.stl");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path << "; set REAMSIM_DATA";
  const MeshDiagnosis found = diagnose(read_mesh(path, 1000));
  EXPECT_EQ(found.boundary_edges, 13U);
  EXPECT_EQ(found.nonmanifold_edges, 23U);
  EXPECT_THAT(found.text(), HasSubstr("13 boundary edges (the first at "));
  EXPECT_THAT(found.text(), HasSubstr("23 non-manifold edges"));
}

}  // namespace
}  // namespace reamsim::test
