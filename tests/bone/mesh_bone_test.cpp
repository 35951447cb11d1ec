// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The voxels of a mesh.
#include <sys/resource.h>

#include <filesystem>
#include <numbers>

#include "mesh_bone_fixture.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/scene/load_bone.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

TEST_F(MeshBone, SphereVolumeAndCorticalShell) {
  BoneSettings settings = settings_for(sphere_mesh({3.1, -7.3, 20.7}, 10, 5), 0.25);
  settings.mesh.cortical_mm = 2;
  settings.mesh.cortical_hu = 1500;
  settings.mesh.trabecular_hu = 300;
  const FilledVoxmap voxmap = load(settings);
  const double truth_mm3 = 4.0 / 3 * std::numbers::pi * 1000;
  EXPECT_NEAR(voxmap.bone_mm3(), truth_mm3, 0.004 * truth_mm3);
  EXPECT_EQ(voxmap.frame, "mesh");

  const std::int64_t inner = count_grade(voxmap, kTrabecular);
  const double inner_radius = std::cbrt(static_cast<double>(inner) * voxmap.grid.voxel_mm3() * 0.75 / std::numbers::pi);
  EXPECT_NEAR(10 - inner_radius, 2, 0.03);
  EXPECT_EQ(grade_at(voxmap, {3.1, -7.3, 20.7}), kTrabecular);
  EXPECT_EQ(grade_at(voxmap, {3.1 + 9, -7.3, 20.7}), kCortical);
  EXPECT_EQ(grade_at(voxmap, {3.1 + 10.2, -7.3, 20.7}), 0);
  EXPECT_TRUE(report_.warnings.empty());
}

TEST_F(MeshBone, ALayerOfManyVoxelsIsAsThickAsOneOfFew) {
  BoneSettings settings = settings_for(sphere_mesh({3.1, -7.3, 20.7}, 8, 6), 0.1);
  settings.mesh.cortical_mm = 2;  // 20 voxels: distances are interpolated
  const FilledVoxmap voxmap = load(settings);
  const double inner_mm3 = static_cast<double>(count_grade(voxmap, kTrabecular)) * voxmap.grid.voxel_mm3();
  EXPECT_NEAR(std::cbrt(0.75 * inner_mm3 / std::numbers::pi), 6, 0.01);
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0.6, 0, -0.8), Vec3(-0.577, 0.577, 0.577)}) {
    EXPECT_EQ(grade_at(voxmap, Vec3(3.1, -7.3, 20.7) + 5.9 * axis), kTrabecular) << axis.transpose();
    EXPECT_NE(grade_at(voxmap, Vec3(3.1, -7.3, 20.7) + 6.1 * axis), kTrabecular) << axis.transpose();
  }
}

TEST_F(MeshBone, BoxIsExact) {
  const BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {10, 6, 4}), 0.5);
  EXPECT_DOUBLE_EQ(load(settings).bone_mm3(), 240);
}

TEST_F(MeshBone, ShellThickerThanTheBoneLeavesNoTrabecularBone) {
  BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {6, 6, 4}), 0.5);
  settings.mesh.cortical_mm = 5;
  const FilledVoxmap voxmap = load(settings);
  EXPECT_EQ(count_grade(voxmap, kCortical), voxmap.count_bone());
}

TEST_F(MeshBone, ScaleAndDensityMappingOfTheScenario) {
  BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {1, 1, 1}), 0.5);
  settings.mesh.scale = 8;
  settings.density.ash_fraction = 0.9;
  const FilledVoxmap voxmap = load(settings);
  EXPECT_DOUBLE_EQ(voxmap.bone_mm3(), 512);
  EXPECT_EQ(voxmap.mapping.ash_fraction, 0.9);
  DensityMapping mapping;
  mapping.ash_fraction = 0.9;
  EXPECT_EQ(grade_at(voxmap, {4, 4, 4}), DensityMapping::grade_from_density(mapping.density_from_hu(300)));
}

TEST_F(MeshBone, SameGradesEveryTime) {
  const BoneSettings settings = settings_for(sphere_mesh({0, 0, 0}, 8, 4), 0.4);
  const FilledVoxmap first = load(settings);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(load(settings).grade, first.grade);
}

TEST_F(MeshBone, SmallHolesNeitherStopARunNorChangeAVolume) {
  TriangleMesh mesh = sphere_mesh({0, 0, 0}, 12, 4);
  const double truth_mm3 = mesh.volume_mm3();
  for (int hole = 0; hole < 8; ++hole) mesh.triangles.erase(mesh.triangles.begin() + 500 * hole);
  for (const SurfaceVoxels surface : {SurfaceVoxels::whole, SurfaceVoxels::partial}) {
    report_ = {};
    BoneSettings settings = settings_for(mesh, 0.4);
    settings.surface_voxels = surface;
    EXPECT_NEAR(load(settings).bone_mm3(), truth_mm3, 0.004 * truth_mm3);
    EXPECT_THAT(report_.warnings, Contains(HasSubstr("the mesh is not clean: ")));
    EXPECT_THAT(report_.notes, Contains(HasSubstr("quality of the mesh: 8 holes, ")));
  }
}

TEST_F(MeshBone, AMeshThatIsNotCleanGivesTheVoxelsOfTheCleanOne) {
  const TriangleMesh sphere = sphere_mesh({3.1, -7.3, 20.7}, 10, 4);
  BoneSettings settings = settings_for(sphere, 0.25);
  settings.mesh.cortical_mm = 2;
  settings.surface_voxels = SurfaceVoxels::partial;
  const FilledVoxmap clean = load(settings);
  TriangleMesh doubled = sphere;
  doubled.triangles.insert(doubled.triangles.end(), sphere.triangles.begin(), sphere.triangles.begin() + 200);
  write_stl(settings.mesh.path, doubled);
  const FilledVoxmap same = load(settings);
  const auto count = static_cast<double>(clean.count_bone());
  EXPECT_NEAR(static_cast<double>(same.count_bone()), count, 1e-3 * count);
  EXPECT_NEAR(same.bone_mm3(), clean.bone_mm3(), 1e-4 * clean.bone_mm3());
  EXPECT_NEAR(static_cast<double>(count_grade(same, kCortical)), static_cast<double>(count_grade(clean, kCortical)),
              0.002 * static_cast<double>(count_grade(clean, kCortical)));
}

TEST_F(MeshBone, ALargeSurfaceInsideAnotherIsBoneAndNotAScaleMistake) {
  const TriangleMesh hollow = joined({box_mesh({0, 0, 0}, {10, 10, 10}), inside_out(box_mesh({1, 1, 1}, {9, 9, 9}))});
  const TriangleMesh nest = joined({hollow, box_mesh({3, 3, 3}, {7, 7, 7})});
  EXPECT_DOUBLE_EQ(load(settings_for(nest, 0.5)).bone_mm3(), 1000);
  EXPECT_THAT(report_.warnings, testing::ElementsAre(HasSubstr("the mesh has 2 surfaces inside another;")));
}

/// Two boxes that overlap by 5 mm along x: 20·10·10 − 5·10·10 mm³.
TriangleMesh overlapping_boxes() {
  return joined({box_mesh({0, 0, 0}, {10, 10, 10}), box_mesh({5, 0, 0}, {15, 10, 10})});
}

TEST_F(MeshBone, OverlappingSurfacesCountOnce) {
  BoneSettings settings = settings_for(overlapping_boxes(), 0.5);
  EXPECT_NEAR(load(settings).bone_mm3(), 1500, 1e-6);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("the mesh overlaps itself")));
  TriangleMesh open = joined({sphere_mesh({0, 0, 0}, 8, 4), sphere_mesh({5, 0, 0}, 8, 4)});
  open.triangles.pop_back();
  settings = settings_for(open, 0.4);
  const double cap_mm = 8 - 2.5, cap_mm3 = std::numbers::pi * cap_mm * cap_mm * (8 - cap_mm / 3);
  const double truth_mm3 = 2 * 4.0 / 3 * std::numbers::pi * 512 - 2 * cap_mm3;
  EXPECT_NEAR(load(settings).bone_mm3(), truth_mm3, 0.01 * truth_mm3);
}

TEST_F(MeshBone, FractionsOfSurfacesThatEncloseOrOverlapOthersCountOnce) {
  const auto volume_mm3 = [&](const TriangleMesh& mesh) {
    BoneSettings settings = settings_for(mesh, 0.5);
    settings.surface_voxels = SurfaceVoxels::partial;
    return load(settings).bone_mm3();
  };
  // A wall of 0.6 mm about a hollow, which is bone, as of any surface inside another.
  const TriangleMesh ball = sphere_mesh({0.1, 0.2, 0.3}, 12, 4), inner = sphere_mesh({0.1, 0.2, 0.3}, 11.4, 4);
  EXPECT_NEAR(volume_mm3(joined({ball, inside_out(inner)})) / ball.volume_mm3(), 1, 1e-6);
  EXPECT_NEAR(volume_mm3(joined({ball, inner})) / ball.volume_mm3(), 1, 1e-6);
  // A plate sunk into a block, whose top is 0.05 mm above that of the block.
  const TriangleMesh block = box_mesh({0.1, 0.2, 0.3}, {40, 40, 40}), plate = box_mesh({10, 10, 39.6}, {30, 30, 40.05});
  const double union_mm3 = block.volume_mm3() + 20 * 20 * 0.05;
  EXPECT_NEAR(volume_mm3(joined({block, plate})), union_mm3, 25) << "by distances";
}

TEST_F(MeshBone, WallsWithinTheSolidAreNoCortex) {
  BoneSettings settings = settings_for(overlapping_boxes(), 0.25);
  settings.mesh.cortical_mm = 1;
  const FilledVoxmap voxmap = load(settings);
  EXPECT_EQ(grade_at(voxmap, {5.1, 5, 5}), kTrabecular);
  EXPECT_EQ(grade_at(voxmap, {9.9, 5, 5}), kTrabecular);
  EXPECT_NE(grade_at(voxmap, {0.2, 5, 5}), kTrabecular);
}

TEST_F(MeshBone, RadiodensityAboveTheDensestGradeIsWarnedOf) {
  BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {10, 6, 4}), 0.5);
  settings.mesh.cortical_hu = 1727;
  load(settings);
  EXPECT_THAT(report_.warnings, testing::IsEmpty());
  settings.mesh.cortical_hu = 2500;
  load(settings);
  EXPECT_THAT(report_.warnings,
              testing::ElementsAre(HasSubstr("bone.mesh.cortical_hu is 2500 HU, denser than 2 g/cm3 (1727 HU)")));
}

TEST_F(MeshBone, SmallerThanAVoxel) {
  const BoneSettings settings = settings_for(box_mesh({0.1, 0.1, 0.1}, {0.2, 0.2, 0.2}), 1);
  EXPECT_THAT(refusal(settings), HasSubstr("no voxel"));
}

/// The most memory that the process has held, bytes.
std::int64_t peak_bytes() {
  struct rusage usage {};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{1024} * usage.ru_maxrss;
}

TEST_F(MeshBone, LatticeThatCannotFit) {
  BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {100, 100, 100}), 0.001);
  const std::int64_t before = peak_bytes();
  EXPECT_THAT(refusal(settings), HasSubstr("would fit"));
  settings.mesh.scale = 1e30;
  settings.voxel_mm = 0.5;
  EXPECT_THAT(refusal(settings), HasSubstr("would fit"));
  EXPECT_LT(peak_bytes() - before, 16'000'000) << "refused before anything is taken";
}

/// A bar from corner to corner of a cube, as wide as its side, along a diagonal of space.
TriangleMesh diagonal_bar(double cube_mm, double side_mm) {
  TriangleMesh bar = box_mesh({-side_mm / 2, -side_mm / 2, 0}, {side_mm / 2, side_mm / 2, std::sqrt(3.0) * cube_mm});
  const Eigen::Matrix3d turn = smallest_rotation(Vec3::UnitZ(), Vec3::Ones()).toRotationMatrix();
  for (Vec3& vertex : bar.vertices) vertex = turn * vertex;
  return bar;
}

TEST_F(MeshBone, AThinBoneIn2048CubedCostsWhatItHolds) {
  const BoneSettings settings = settings_for(diagonal_bar(204, 2), 0.1);
  const std::int64_t before = peak_bytes();
  const FilledVoxmap voxmap = load_bone(settings, report_).copy_voxels();
  EXPECT_GE(voxmap.grid.dims.minCoeff(), 2048);
  const double truth_mm3 = 204 * std::sqrt(3.0) * 4;
  EXPECT_NEAR(voxmap.bone_mm3(), truth_mm3, 0.01 * truth_mm3);

  // No stored brick lies further from the bar than its own diagonal, 1.4 mm.
  const auto most_bricks = static_cast<std::size_t>((204 * std::sqrt(3.0) + 2.8) * 4.8 * 4.8 / (0.8 * 0.8 * 0.8));
  EXPECT_LT(voxmap.grade.stored_bricks(), most_bricks);
  const std::size_t table_bytes = sizeof(std::int32_t) * BrickLattice::over(voxmap.grid.dims).count();
  EXPECT_EQ(voxmap.grade.bytes(), table_bytes + 512 * voxmap.grade.stored_bricks());
  EXPECT_EQ(voxmap.fill.bytes(), table_bytes);

  write_bone_vdb(dir_.path() + "/bar.vdb", voxmap, {}, {});
  EXPECT_LT(std::filesystem::file_size(dir_.path() + "/bar.vdb"), 8192 * voxmap.grade.stored_bricks());
  EXPECT_TRUE(read_stored_bone(dir_.path() + "/bar.vdb").voxmap.grade == voxmap.grade);
  // Eight bytes a voxel of the stored bricks, and the tables three times, against 8.6 GB of dense grades.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // whose own memory would be measured
  EXPECT_LT(peak_bytes() - before, 900'000'000);
#else
  EXPECT_LT(before, peak_bytes());
#endif
}

TEST_F(MeshBone, TheAdvisedVoxelSizeFits) {
  BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {1000, 1000, 1000}), 0.01);
  const std::string text = refusal(settings);
  const std::string key = "bone.voxel_mm of ";
  const std::size_t at = text.find(key);
  ASSERT_NE(at, std::string::npos) << text;
  const double advised_mm = std::stod(text.substr(at + key.size()));
  EXPECT_GT(advised_mm, 0.3);  // 1000 mm over some 2048 voxels, or fewer on a small machine
  EXPECT_LT(advised_mm, 2.5);
}

TEST_F(MeshBone, RealScapula) {
  BoneSettings settings;
  settings.voxel_mm = 0.8;
  settings.mesh.path = data_file("scapula_mesh/scapula_left.stl");
  settings.mesh.scale = 55;
  if (!std::filesystem::exists(settings.mesh.path)) {
    GTEST_SKIP() << "no " << settings.mesh.path << "; set REAMSIM_DATA";
  }
  const double truth_mm3 = read_mesh(settings.mesh.path, 55).volume_mm3();
  const FilledVoxmap voxmap = load(settings);
  EXPECT_NEAR(voxmap.bone_mm3(), truth_mm3, 0.005 * truth_mm3);
  EXPECT_NE(grade_at(voxmap, Vec3(-41.2, 9.2, 36.6) - 5 * Vec3(-0.93, 0.355, -0.08)), 0) << "behind the glenoid";
  EXPECT_EQ(grade_at(voxmap, Vec3(-41.2, 9.2, 36.6) + 5 * Vec3(-0.93, 0.355, -0.08)), 0) << "in front of it";
}

}  // namespace
}  // namespace reamsim::test
