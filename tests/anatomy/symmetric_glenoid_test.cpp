// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The face of a real scapula from points round its centre, also of the mirrored and of the turned scapula.
#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>
#include <random>

#include "sim/anatomy/find_glenoid.h"
#include "sim/mesh/mesh_io.h"
#include "tests/bone/phantom_truth.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

constexpr unsigned kPointSeed = 5;

Mat3 mirror_in_x() {
  return Vec3(-1, 1, 1).asDiagonal();
}
Mat3 turn(double angle, const Vec3& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

class SymmetricGlenoid : public testing::Test {
 protected:
  void SetUp() override {
    const std::string file = data_file("scapula_mesh/scapula_left.stl");
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file << "; set REAMSIM_DATA";
    mesh_ = read_mesh(file, 55);
  }
  FilledVoxmap bone_of(const Mat3& isometry) {
    TriangleMesh mesh = mesh_;
    for (Vec3& vertex : mesh.vertices) vertex = isometry * vertex;
    if (isometry.determinant() < 0) {
      for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    }
    BoneSettings settings;
    settings.source = BoneSource::mesh;
    settings.surface_voxels = SurfaceVoxels::partial;
    settings.voxel_mm = 0.6;
    settings.mesh.path = folder_.path() + "/bone.stl";
    write_stl(settings.mesh.path, mesh);
    return voxmap_from_mesh(settings, report_);
  }

  TempDir folder_;
  Diagnostics report_;
  TriangleMesh mesh_;
};

/// Where the search rests depends a little on the point, the lattice and the directions of the walks.
TEST_F(SymmetricGlenoid, HasTheSameFrameFromAnyPoint) {
  const Vec3 center(-39.1, 8.3, 35.1);
  std::mt19937 random(kPointSeed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Vec3> centers, normals;
  for (const Mat3& isometry :
       {Mat3(Mat3::Identity()), mirror_in_x(), turn(0.7, {1, 2, 3}), Mat3(mirror_in_x() * turn(-1.1, {2, -1, 1}))}) {
    const FilledVoxmap bone = bone_of(isometry);
    for (int n = 0; n < 3;) {
      const Vec3 off(uniform(random), uniform(random), uniform(random));
      if (off.norm() > 1) continue;
      ++n;
      GlenoidSettings glenoid;
      glenoid.near_mm = isometry * Vec3(center + 8 * off);
      const Rigid frame = find_glenoid(bone, glenoid, BodySide::left).frame.bone_from_glenoid;
      centers.emplace_back(isometry.transpose() * frame.translation());
      normals.emplace_back(isometry.transpose() * frame.linear().col(2));
    }
  }
  double apart_mm = 0, apart_deg = 0;
  for (std::size_t i = 0; i < centers.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      apart_mm = std::max(apart_mm, (centers[i] - centers[j]).norm());
      apart_deg = std::max(apart_deg, angle_deg(normals[i], normals[j]));
    }
  }
  std::cout << "seed " << kPointSeed << ": centres within " << apart_mm << " mm, normals within " << apart_deg
            << " deg\n";
  EXPECT_LE(apart_mm, 0.5);
  EXPECT_LE(apart_deg, 1);
}

}  // namespace
}  // namespace reamsim::test
