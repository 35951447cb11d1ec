// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/mesh_fractions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>

#include "sim/bone/voxmap/cube_fraction.h"

namespace reamsim::test::mesh_fractions_tests {
namespace {

constexpr unsigned kSeed = 48;
const VoxelGrid kGrid{{16, 17, 18}, 0.5, {-3, -4, -5}};

/// A box about the origin, turned and moved.
TriangleMesh box(const Vec3& half, const Rigid& place) {
  TriangleMesh out;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    out.vertices.push_back(place * half.cwiseProduct(sign));
  }
  out.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return out;
}

/// Of the voxels that triangles intersect, and of the others by their centre.
template <class Inside>
double sum_mm3(const TriangleMesh& mesh, const Inside& inside) {
  const MeshFractions fractions(mesh, kGrid);
  double sum = 0;
  for_each_voxel(kGrid.dims, [&](const Vec3i& voxel) {
    const double fraction = fractions.at(voxel).value_or(inside(kGrid.center_mm(voxel)) ? 1 : 0);
    EXPECT_GE(fraction, -1e-6) << voxel.transpose();
    EXPECT_LE(fraction, 1 + 1e-6) << voxel.transpose();
    sum += fraction;
  });
  return sum * std::pow(kGrid.voxel_mm, 3);
}

TEST(MeshFractions, OfBoxesAddUpToTheirVolume) {
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 40; ++i) {
    // Down to walls of 0.04 voxel.
    const Vec3 half(i % 4 == 0 ? 0.01 : 0.8 + 0.6 * u(random), 1.1 + 0.5 * u(random), 1.5 + 0.5 * u(random));
    Rigid place = Rigid::Identity();
    place.translation() = Vec3(1, 0.1, -0.4) + 0.3 * Vec3(u(random), u(random), u(random));
    place.linear() = Quat(u(random), u(random), u(random), u(random)).normalized().toRotationMatrix();
    const Rigid back = place.inverse();
    const auto inside = [&](const Vec3& p) { return ((back * p).cwiseAbs().array() < half.array()).all(); };
    EXPECT_NEAR(sum_mm3(box(half, place), inside), 8 * half.prod(), 1e-5) << i;
  }
}

TEST(MeshFractions, OfBoxesOnTheLatticeAreThoseOfTheirFaces) {
  for (const double beyond : {0.0, 0.25, 0.5}) {  // faces of the lattice, middles of voxels, and the next faces
    const Aabb bounds{Vec3(-1, -2, -1), Vec3(1 + beyond, 2, 1 + beyond)};
    Rigid place = Rigid::Identity();
    place.translation() = bounds.center();
    const MeshFractions fractions(box(bounds.half(), place), kGrid);
    for_each_voxel(kGrid.dims, [&](const Vec3i& voxel) {
      const double expected = fraction_in_box(bounds, kGrid.center_mm(voxel), kGrid.voxel_mm);
      if (const auto found = fractions.at(voxel)) {
        EXPECT_NEAR(*found, expected, 1e-6) << voxel.transpose();
      } else {
        EXPECT_TRUE(expected == 0 || expected == 1) << voxel.transpose();
      }
    });
  }
}

TEST(MeshFractions, OfATiltedFaceAreThoseOfThePlane) {
  const Vec3 normal = Vec3(0.3, -0.2, 0.7).normalized();
  Rigid place = Rigid::Identity();
  place.linear() = Quat::FromTwoVectors(Vec3::UnitZ(), normal).toRotationMatrix();
  place.translation() = Vec3(1, 0.2, -0.5) - 20 * normal;
  const MeshFractions fractions(box({30, 30, 20}, place), kGrid);  // wider than the lattice, its upper face within
  const float n[3] = {static_cast<float>(normal.x()), static_cast<float>(normal.y()), static_cast<float>(normal.z())};
  int found = 0;
  for_each_voxel(kGrid.dims, [&](const Vec3i& voxel) {
    const double away = normal.dot(kGrid.center_mm(voxel) - Vec3(1, 0.2, -0.5)) / kGrid.voxel_mm;
    const auto fraction = fractions.at(voxel);
    if (!fraction) return;
    ++found;
    EXPECT_NEAR(*fraction, 1 - rs_outside_fraction(n, static_cast<float>(away)), 1e-5) << voxel.transpose();
  });
  EXPECT_GT(found, 300);
}

}  // namespace
}  // namespace reamsim::test::mesh_fractions_tests
