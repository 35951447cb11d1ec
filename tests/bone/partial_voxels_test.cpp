// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Voxels that the bone's surface passes through hold the part of them that is bone: volumes against closed forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <iostream>
#include <numbers>

#include "bone_fixture.h"
#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/mesh/mesh_io.h"
#include "sim/scene/load_bone.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

using std::numbers::pi;

constexpr std::array kVoxels_mm = {1.0, 0.5, 0.25};
using Errors = std::array<double, kVoxels_mm.size()>;

/// The bone's volume, mm³, for settings made for a voxel size.
double volume(BoneSettings settings, SurfaceVoxels surface_voxels) {
  settings.surface_voxels = surface_voxels;
  Diagnostics report;
  return load_bone(settings, report).view().bone_mm3();
}

/// Root mean square over bones of the relative error of the volume, by voxel size.
template <class Make>
Errors rms_errors(const Make& make, int bones, SurfaceVoxels surface_voxels) {
  Errors out{};
  for (std::size_t level = 0; level < kVoxels_mm.size(); ++level) {
    for (int bone = 0; bone < bones; ++bone) {
      double truth_mm3 = 0;
      const BoneSettings settings = make(bone, kVoxels_mm[level], truth_mm3);
      const double error = volume(settings, surface_voxels) / truth_mm3 - 1;
      out[level] += error * error / bones;
    }
    out[level] = std::sqrt(out[level]);
    std::cout << name_of(surface_voxels) << ", " << kVoxels_mm[level] << " mm: RMS " << 100 * out[level] << " %\n";
  }
  return out;
}

/// Second order, and a tenth at most of what whole voxels err by.
template <class Make>
void expect_second_order(const Make& make, int bones) {
  const Errors partial = rms_errors(make, bones, SurfaceVoxels::partial);
  const Errors whole = rms_errors(make, bones, SurfaceVoxels::whole);
  for (std::size_t level = 0; level < kVoxels_mm.size(); ++level) EXPECT_LT(10 * partial[level], whole[level]);
  EXPECT_GT(std::log2(partial.front() / partial.back()) / (kVoxels_mm.size() - 1), 1.8);
}

TEST(PartialVoxels, ShareOfAPlaneIsThatOfTheClippedCube) {
  const auto plane = [](const Vec3& p) { return 3 * (p.x() - 0.2) / 0.5; };
  EXPECT_NEAR(fraction_inside(plane, {0.1, 5, 7}, 0.5), 0.7, 1e-6);
  EXPECT_EQ(fraction_inside(plane, {-0.2, 5, 7}, 0.5), 1);
  EXPECT_EQ(fraction_inside(plane, {0.6, 5, 7}, 0.5), 0);
}

TEST(PartialVoxels, SharesOfEdgesAndThinWallsAreFoundByHalving) {
  const auto edge = [](const Vec3& p) { return std::max(p.x() - 0.1, p.y() + 0.15); };
  EXPECT_NEAR(fraction_inside(edge, Vec3::Zero(), 1), 0.6 * 0.35, 0.02);
  const auto wall = [](const Vec3& p) { return std::abs(p.z() - 0.05) - 0.15; };
  EXPECT_NEAR(fraction_inside(wall, Vec3::Zero(), 1), 0.3, 0.05);
}

class PartialMesh : public ::testing::Test {
 protected:
  [[nodiscard]] BoneSettings settings_for(const TriangleMesh& mesh, double voxel_mm) const {
    BoneSettings settings;
    settings.source = BoneSource::mesh;
    settings.voxel_mm = voxel_mm;
    settings.mesh.path = dir_.path() + "/bone.stl";
    write_stl(settings.mesh.path, mesh);
    return settings;
  }

  TempDir dir_;
};

TEST_F(PartialMesh, EllipsoidConvergesWithSecondOrder) {
  expect_second_order(
      [this](int bone, double voxel_mm, double& truth_mm3) {
        TriangleMesh mesh = sphere_mesh(Vec3::Zero(), 1, 5);
        const Vec3 center(0.37 * bone, -0.21 * bone, 3 + 0.13 * bone);
        const Quat turned(Eigen::AngleAxisd(0.3 * bone, Vec3(1, 2, 3).normalized()));
        for (Vec3& v : mesh.vertices) v = center + turned * Vec3(8, 10, 12).cwiseProduct(v);
        truth_mm3 = mesh.volume_mm3();
        return settings_for(mesh, voxel_mm);
      },
      3);
}

TEST_F(PartialMesh, TurnedBoxErrsOnlyAtItsEdges) {
  // Distances known at voxels' centres round an edge off, by 0.13 of a voxel's section.
  for (const double voxel_mm : kVoxels_mm) {
    TriangleMesh mesh = box_mesh({-7, -5, -4}, {7, 5, 4});
    const Quat turned(Eigen::AngleAxisd(0.5, Vec3(2, 1, -1).normalized()));
    for (Vec3& v : mesh.vertices) v = turned * v + Vec3(0.1, 0.2, 0.3);
    EXPECT_NEAR(volume(settings_for(mesh, voxel_mm), SurfaceVoxels::partial) / (14 * 10 * 8), 1,
                0.017 * voxel_mm * voxel_mm);
  }
}

TEST_F(PartialMesh, PlateOfAVoxelAndABit) {
  TriangleMesh mesh = box_mesh({-10, -10, -0.35}, {10, 10, 0.35});
  const Quat turned(Eigen::AngleAxisd(0.4, Vec3(1, 3, 0).normalized()));
  for (Vec3& v : mesh.vertices) v = turned * v;
  EXPECT_NEAR(volume(settings_for(mesh, 0.5), SurfaceVoxels::partial) / (20 * 20 * 0.7), 1, 0.04);
}

TEST_F(PartialMesh, BoxOnTheLatticeStaysWholeButForItsEdges) {
  BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {10, 6, 4}), 0.5);
  settings.surface_voxels = SurfaceVoxels::partial;
  Diagnostics report;
  const FilledVoxmap voxmap = load_bone(settings, report).copy_voxels();
  EXPECT_NEAR(voxmap.bone_mm3(), 240, 0.01 * 240);  // its edges are rounded
  EXPECT_EQ(grade_at(voxmap, {5, 3, 4.1}), 0) << "nothing outside a face";
  EXPECT_EQ(voxmap.fill.get(voxmap.grid.voxel_of({5, 3, 3.9})), FillBricks::kWhole);
}

TEST_F(PartialMesh, VoxelsJustOutsideAreCorticalAndHoldLittle) {
  BoneSettings settings = settings_for(sphere_mesh({0.1, 0.2, 0.3}, 9, 5), 0.5);
  Diagnostics report;
  const FilledVoxmap whole = load_bone(settings, report).copy_voxels();
  settings.surface_voxels = SurfaceVoxels::partial;
  const FilledVoxmap voxmap = load_bone(settings, report).copy_voxels();
  const int cortical = DensityMapping::grade_from_density(DensityMapping().density_from_hu(settings.mesh.cortical_hu));
  std::int64_t outside = 0;
  for_each_bone_voxel(voxmap, [&](const Vec3i& voxel, std::uint8_t grade, std::uint16_t fill) {
    EXPECT_GT(fill, 0);
    const Vec3 center = voxmap.grid.center_mm(voxel);
    if (grade_at(whole, center) != 0) {
      EXPECT_EQ(grade, grade_at(whole, center));
      return;
    }
    ++outside;
    EXPECT_EQ(grade, cortical);
    EXPECT_LT(fill, 0.6 * FillBricks::kWhole);
    EXPECT_LT((center - Vec3(0.1, 0.2, 0.3)).norm(), 9 + 0.5 * 0.87);
  });
  EXPECT_GT(outside, 1000);
}

TEST_F(PartialMesh, SameFillEveryTime) {
  BoneSettings settings = settings_for(sphere_mesh({0, 0, 0}, 8, 4), 0.4);
  settings.surface_voxels = SurfaceVoxels::partial;
  Diagnostics report;
  const FilledVoxmap first = load_bone(settings, report).copy_voxels();
  for (int i = 0; i < 3; ++i) {
    const FilledVoxmap again = load_bone(settings, report).copy_voxels();
    EXPECT_EQ(again.grade, first.grade);
    EXPECT_EQ(dense_fill(again), dense_fill(first));
  }
}

TEST(PartialPhantom, SphereConvergesWithSecondOrder) {
  expect_second_order(
      [](int bone, double voxel_mm, double& truth_mm3) {
        BoneSettings settings = phantom(PhantomShape::sphere, voxel_mm);
        settings.phantom.radius_mm = 9 + 0.37 * bone;
        truth_mm3 = 4.0 / 3 * pi * std::pow(settings.phantom.radius_mm, 3);
        return settings;
      },
      5);
}

TEST(PartialPhantom, CupConvergesWithSecondOrder) {
  for (const double voxel_mm : kVoxels_mm) {
    BoneSettings settings = phantom(PhantomShape::cup, voxel_mm);
    settings.phantom.size_mm = {32.3, 31.9, 8.1};
    settings.phantom.radius_mm = 20;
    settings.phantom.cup_depth_mm = 4;
    const double truth_mm3 = 32.3 * 31.9 * 8.1 - pi * 4 * 4 * (3 * 20 - 4) / 3;
    EXPECT_NEAR(volume(settings, SurfaceVoxels::partial) / truth_mm3, 1, 4e-4 * voxel_mm * voxel_mm);
  }
}

TEST(PartialPhantom, BlockOfAnySizeIsExact) {
  for (const PhantomShape shape : {PhantomShape::half_space, PhantomShape::layered}) {
    BoneSettings settings = phantom(shape, 0.4);
    settings.phantom.size_mm = {10.1, 12.3, 5.57};
    EXPECT_NEAR(volume(settings, SurfaceVoxels::partial) / (10.1 * 12.3 * 5.57), 1, 1e-5) << name_of(shape);
  }
}

TEST(PartialPhantom, GlenoidsOfCoarseAndFineVoxelsAgree) {
  const BoneSettings fine = phantom(PhantomShape::glenoid, 0.3), coarse = phantom(PhantomShape::glenoid, 1.2);
  const double truth_mm3 = volume(fine, SurfaceVoxels::partial);
  const double partial = volume(coarse, SurfaceVoxels::partial) / truth_mm3 - 1,
               whole = volume(coarse, SurfaceVoxels::whole) / truth_mm3 - 1;
  std::cout << "glenoid, 1.2 mm: " << 100 * partial << " %, whole voxels " << 100 * whole << " %\n";
  EXPECT_LT(std::abs(partial), 1e-3);
}

TEST(PartialPhantom, AutoIsPartialForExactOnly) {
  CuttingSettings cutting;
  BoneSettings bone;
  cutting.erosion = ErosionMode::exact;
  EXPECT_EQ(with_surface_voxels(bone, cutting).surface_voxels, SurfaceVoxels::partial);
  for (const ErosionMode erosion : {ErosionMode::remove, ErosionMode::wear}) {
    cutting.erosion = erosion;
    EXPECT_EQ(with_surface_voxels(bone, cutting).surface_voxels, SurfaceVoxels::whole);
  }
  bone.surface_voxels = SurfaceVoxels::partial;
  EXPECT_EQ(with_surface_voxels(bone, cutting).surface_voxels, SurfaceVoxels::partial);
}

TEST(PartialHole, TakesTheCylinderOutOfTheVoxels) {
  BoneSettings settings = phantom(PhantomShape::half_space, 0.5);
  PilotHoleSettings hole;
  hole.diameter_mm = 4;
  hole.entry_mm = {-5, 0.3, -8};
  hole.axis = {5, 1, -2};
  hole.depth_mm = 8;
  const double truth_mm3 = pi * 4 * 8;
  Diagnostics report;
  FilledVoxmap bone = bone_from_phantom(settings, report).copy_voxels();
  const double before_mm3 = bone.bone_mm3();
  const double drilled_mm3 = drill_pilot_hole(bone, hole, {}, true);
  EXPECT_NEAR(drilled_mm3, truth_mm3, 0.002 * truth_mm3);
  EXPECT_NEAR(before_mm3 - bone.bone_mm3(), drilled_mm3, 1e-6);
}

}  // namespace
}  // namespace reamsim::test
