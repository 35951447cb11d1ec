// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "bone_fixture.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/mesh/mesh_io.h"
#include "sim/scene/load_bone.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

class MeshBone : public ::testing::Test {
 protected:
  BoneSettings settings_for(const TriangleMesh& mesh, double voxel_mm) const {
    BoneSettings settings;
    settings.source = BoneSource::mesh;
    settings.voxel_mm = voxel_mm;
    settings.mesh.path = dir_.path() + "/bone.stl";
    write_stl(settings.mesh.path, mesh);
    return settings;
  }

  TempDir dir_;
  Diagnostics report_;
};

TEST_F(MeshBone, SphereVolumeAndCorticalShell) {
  BoneSettings settings = settings_for(sphere_mesh({3.1, -7.3, 20.7}, 10, 5), 0.25);
  settings.mesh.cortical_mm = 2;
  settings.mesh.cortical_hu = 1500;
  settings.mesh.trabecular_hu = 300;
  const FilledVoxmap voxmap = voxmap_from_mesh(settings, report_);
  const double truth_mm3 = 4.0 / 3 * std::numbers::pi * 1000;
  EXPECT_NEAR(voxmap.bone_mm3(), truth_mm3, 0.004 * truth_mm3);
  EXPECT_EQ(voxmap.frame, "mesh");

  const int cortical = DensityMapping::grade_from_density(DensityMapping().density_from_hu(1500));
  const int trabecular = DensityMapping::grade_from_density(DensityMapping().density_from_hu(300));
  const std::int64_t inner = count_grade(voxmap, trabecular);
  const double inner_radius = std::cbrt(static_cast<double>(inner) * voxmap.grid.voxel_mm3() * 0.75 / std::numbers::pi);
  EXPECT_NEAR(10 - inner_radius, 2, 0.03);
  EXPECT_EQ(grade_at(voxmap, {3.1, -7.3, 20.7}), trabecular);
  EXPECT_EQ(grade_at(voxmap, {3.1 + 9, -7.3, 20.7}), cortical);
  EXPECT_EQ(grade_at(voxmap, {3.1 + 10.2, -7.3, 20.7}), 0);
  EXPECT_TRUE(report_.warnings.empty());
}

TEST_F(MeshBone, ALayerOfManyVoxelsIsAsThickAsOneOfFew) {
  BoneSettings settings = settings_for(sphere_mesh({3.1, -7.3, 20.7}, 8, 6), 0.1);
  settings.mesh.cortical_mm = 2;  // 20 voxels: distances are interpolated
  const int trabecular = DensityMapping::grade_from_density(DensityMapping().density_from_hu(300));
  const FilledVoxmap voxmap = voxmap_from_mesh(settings, report_);
  const double inner_mm3 = static_cast<double>(count_grade(voxmap, trabecular)) * voxmap.grid.voxel_mm3();
  EXPECT_NEAR(std::cbrt(0.75 * inner_mm3 / std::numbers::pi), 6, 0.01);
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0.6, 0, -0.8), Vec3(-0.577, 0.577, 0.577)}) {
    EXPECT_EQ(grade_at(voxmap, Vec3(3.1, -7.3, 20.7) + 5.9 * axis), trabecular) << axis.transpose();
    EXPECT_NE(grade_at(voxmap, Vec3(3.1, -7.3, 20.7) + 6.1 * axis), trabecular) << axis.transpose();
  }
}

TEST_F(MeshBone, BoxIsExact) {
  const BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {10, 6, 4}), 0.5);
  EXPECT_DOUBLE_EQ(voxmap_from_mesh(settings, report_).bone_mm3(), 240);
}

TEST_F(MeshBone, ShellThickerThanTheBoneLeavesNoTrabecularBone) {
  BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {6, 6, 4}), 0.5);
  settings.mesh.cortical_mm = 5;
  const FilledVoxmap voxmap = voxmap_from_mesh(settings, report_);
  const int cortical = DensityMapping::grade_from_density(DensityMapping().density_from_hu(1500));
  EXPECT_EQ(count_grade(voxmap, cortical), voxmap.count_bone());
}

TEST_F(MeshBone, ScaleAndDensityMappingOfTheScenario) {
  BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {1, 1, 1}), 0.5);
  settings.mesh.scale = 8;
  settings.density.ash_fraction = 0.9;
  const FilledVoxmap voxmap = voxmap_from_mesh(settings, report_);
  EXPECT_DOUBLE_EQ(voxmap.bone_mm3(), 512);
  EXPECT_EQ(voxmap.mapping.ash_fraction, 0.9);
  DensityMapping mapping;
  mapping.ash_fraction = 0.9;
  EXPECT_EQ(grade_at(voxmap, {4, 4, 4}), DensityMapping::grade_from_density(mapping.density_from_hu(300)));
}

TEST_F(MeshBone, SameGradesEveryTime) {
  const BoneSettings settings = settings_for(sphere_mesh({0, 0, 0}, 8, 4), 0.4);
  const FilledVoxmap first = voxmap_from_mesh(settings, report_);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(voxmap_from_mesh(settings, report_).grade, first.grade);
}

TEST_F(MeshBone, InsideOutIsTurnedAndSaid) {
  const BoneSettings settings = settings_for(inside_out(sphere_mesh({0, 0, 0}, 8, 3)), 0.5);
  const double truth_mm3 = sphere_mesh({0, 0, 0}, 8, 3).volume_mm3();
  EXPECT_NEAR(voxmap_from_mesh(settings, report_).bone_mm3(), truth_mm3, 0.01 * truth_mm3);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("face inwards")));
}

TEST_F(MeshBone, OpenMeshIsRefusedUntilRepairIsAskedFor) {
  TriangleMesh mesh = sphere_mesh({0, 0, 0}, 8, 3);
  const double truth_mm3 = mesh.volume_mm3();
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 16);
  BoneSettings settings = settings_for(mesh, 0.4);
  const std::string text = input_error([&] { voxmap_from_mesh(settings, report_); });
  EXPECT_THAT(text, HasSubstr(settings.mesh.path));
  EXPECT_THAT(text, HasSubstr("boundary edges (the first at "));
  EXPECT_THAT(text, HasSubstr("1 hole, "));
  EXPECT_THAT(text, HasSubstr("bone.mesh.repair"));
  settings.mesh.repair = true;
  EXPECT_NEAR(voxmap_from_mesh(settings, report_).bone_mm3(), truth_mm3, 0.01 * truth_mm3);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("1 holes closed")));
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("volume of the mesh by winding numbers: ")));
}

TEST_F(MeshBone, ARepairThatChangesTheVolumeIsRefusedUnlessAskedFor) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {20, 20, 20});
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 6);  // three faces of six
  BoneSettings settings = settings_for(mesh, 0.5);
  settings.mesh.repair = true;
  const std::string text = input_error([&] { voxmap_from_mesh(settings, report_); });
  EXPECT_THAT(text, HasSubstr("bone.mesh.repair: closing the holes would change the volume by more than 1 %: "));
  EXPECT_THAT(text, HasSubstr("bone.mesh.repair_change_percent: "));
  settings.mesh.repair_change_percent = 1000;
  EXPECT_GT(voxmap_from_mesh(settings, report_).bone_mm3(), 100);
}

TEST_F(MeshBone, SmallHolesNeitherStopARunNorChangeAVolume) {
  TriangleMesh mesh = sphere_mesh({0, 0, 0}, 12, 4);
  const double truth_mm3 = mesh.volume_mm3();
  for (int hole = 0; hole < 8; ++hole) mesh.triangles.erase(mesh.triangles.begin() + 500 * hole);
  for (const SurfaceVoxels surface : {SurfaceVoxels::whole, SurfaceVoxels::partial}) {
    report_ = {};
    BoneSettings settings = settings_for(mesh, 0.4);
    settings.surface_voxels = surface;
    EXPECT_NEAR(voxmap_from_mesh(settings, report_).bone_mm3(), truth_mm3, 0.004 * truth_mm3);
    EXPECT_THAT(report_.warnings, Contains(HasSubstr("the mesh is not clean: ")));
    EXPECT_THAT(report_.notes, Contains(HasSubstr("quality of the mesh: 8 holes, ")));
  }
}

TEST_F(MeshBone, AMeshThatIsNotCleanGivesTheVoxelsOfTheCleanOne) {
  const TriangleMesh sphere = sphere_mesh({3.1, -7.3, 20.7}, 10, 4);
  BoneSettings settings = settings_for(sphere, 0.25);
  settings.mesh.cortical_mm = 2;
  settings.surface_voxels = SurfaceVoxels::partial;
  const FilledVoxmap clean = voxmap_from_mesh(settings, report_);
  TriangleMesh doubled = sphere;
  doubled.triangles.insert(doubled.triangles.end(), sphere.triangles.begin(), sphere.triangles.begin() + 200);
  write_stl(settings.mesh.path, doubled);
  const FilledVoxmap same = voxmap_from_mesh(settings, report_);
  const auto count = static_cast<double>(clean.count_bone());
  EXPECT_NEAR(static_cast<double>(same.count_bone()), count, 1e-3 * count);
  EXPECT_NEAR(same.bone_mm3(), clean.bone_mm3(), 1e-4 * clean.bone_mm3());
  const int cortical = DensityMapping::grade_from_density(DensityMapping().density_from_hu(1500));
  EXPECT_NEAR(static_cast<double>(count_grade(same, cortical)), static_cast<double>(count_grade(clean, cortical)),
              0.002 * static_cast<double>(count_grade(clean, cortical)));
}

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const auto before = static_cast<std::int32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& [i, j, k] : b.triangles) a.triangles.push_back({i + before, j + before, k + before});
  return a;
}

TEST_F(MeshBone, APieceBesidesTheBoneIsNamed) {
  const TriangleMesh bone = box_mesh({0, 0, 0}, {10, 10, 10});
  voxmap_from_mesh(settings_for(joined(box_mesh({20, 2, 4}, {22, 6, 6}), bone), 0.5), report_);
  EXPECT_THAT(report_.warnings,
              testing::ElementsAre("the mesh has a piece besides the largest: 16 mm3 at (21.0, 4.0, 5.0) mm; all are "
                                   "kept as bone: remove in the mesh what is no bone"));
  report_ = {};
  voxmap_from_mesh(settings_for(joined(bone, box_mesh({3, 3, 3}, {6, 6, 6})), 0.5), report_);
  EXPECT_THAT(report_.warnings,
              testing::ElementsAre("the mesh has a surface inside another; a surface inside another does not create a "
                                   "cavity"));
}

TEST_F(MeshBone, EachPieceThatFacesInwardsIsTurnedAndSaid) {
  const TriangleMesh bone = box_mesh({0, 0, 0}, {10, 10, 10}), other = box_mesh({20, 0, 0}, {28, 8, 8});
  EXPECT_DOUBLE_EQ(voxmap_from_mesh(settings_for(joined(bone, inside_out(other)), 0.5), report_).bone_mm3(), 1512);
  EXPECT_THAT(report_.warnings,
              testing::ElementsAre("the triangles of a piece of the mesh face inwards: 512 mm3 at (24.0, 4.0, 4.0) mm; "
                                   "orientation flipped",
                                   HasSubstr("a piece besides the largest: 512 mm3")));
  report_ = {};
  const TriangleMesh twin = box_mesh({20, 0, 0}, {30, 10, 10});
  EXPECT_DOUBLE_EQ(voxmap_from_mesh(settings_for(joined(bone, inside_out(twin)), 0.5), report_).bone_mm3(), 2000)
      << "the signed volumes add up to 0";
}

TEST_F(MeshBone, TheRepairTurnsAPieceOfWhichMostFacesInwards) {
  TriangleMesh other = box_mesh({20, 0, 0}, {28, 8, 8});
  for (std::size_t i = 0; i < 8; ++i) std::swap(other.triangles[i][1], other.triangles[i][2]);
  BoneSettings settings = settings_for(joined(box_mesh({0, 0, 0}, {10, 10, 10}), other), 0.5);
  settings.mesh.repair = true;
  EXPECT_DOUBLE_EQ(voxmap_from_mesh(settings, report_).bone_mm3(), 1512);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("4 triangles turned")));
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("a piece of the mesh face inwards: 512 mm3")));
}

TEST_F(MeshBone, ALargeSurfaceInsideAnotherIsBoneAndNotAScaleMistake) {
  const TriangleMesh hollow = joined(box_mesh({0, 0, 0}, {10, 10, 10}), inside_out(box_mesh({1, 1, 1}, {9, 9, 9})));
  const TriangleMesh nest = joined(hollow, box_mesh({3, 3, 3}, {7, 7, 7}));
  EXPECT_DOUBLE_EQ(voxmap_from_mesh(settings_for(nest, 0.5), report_).bone_mm3(), 1000);
  EXPECT_THAT(report_.warnings, testing::ElementsAre(HasSubstr("the mesh has 2 surfaces inside another;")));
}

TEST_F(MeshBone, TrianglesOfMixedOrientationAreTurnedByTheRepair) {
  TriangleMesh mesh = sphere_mesh({0, 0, 0}, 8, 3);
  const double truth_mm3 = mesh.volume_mm3();
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
  BoneSettings settings = settings_for(mesh, 0.4);
  EXPECT_THAT(input_error([&] { voxmap_from_mesh(settings, report_); }),
              testing::AllOf(HasSubstr("no consistent orientation"), HasSubstr("bone.mesh.repair: true, which turns")));
  settings.mesh.repair = true;
  EXPECT_NEAR(voxmap_from_mesh(settings, report_).bone_mm3(), truth_mm3, 0.01 * truth_mm3);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("triangles turned")));
}

/// Two boxes that overlap by 5 mm along x: 20·10·10 − 5·10·10 mm³.
TriangleMesh overlapping_boxes() {
  return joined(box_mesh({0, 0, 0}, {10, 10, 10}), box_mesh({5, 0, 0}, {15, 10, 10}));
}

TEST_F(MeshBone, OverlappingSurfacesCountOnce) {
  BoneSettings settings = settings_for(overlapping_boxes(), 0.5);
  EXPECT_NEAR(voxmap_from_mesh(settings, report_).bone_mm3(), 1500, 1e-6);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("the mesh overlaps itself")));
  TriangleMesh open = joined(sphere_mesh({0, 0, 0}, 8, 4), sphere_mesh({5, 0, 0}, 8, 4));
  open.triangles.pop_back();
  settings = settings_for(open, 0.4);
  const double cap_mm = 8 - 2.5, cap_mm3 = std::numbers::pi * cap_mm * cap_mm * (8 - cap_mm / 3);
  const double truth_mm3 = 2 * 4.0 / 3 * std::numbers::pi * 512 - 2 * cap_mm3;
  EXPECT_NEAR(voxmap_from_mesh(settings, report_).bone_mm3(), truth_mm3, 0.01 * truth_mm3);
}

TEST_F(MeshBone, WallsWithinTheSolidAreNoCortex) {
  BoneSettings settings = settings_for(overlapping_boxes(), 0.25);
  settings.mesh.cortical_mm = 1;
  const FilledVoxmap voxmap = voxmap_from_mesh(settings, report_);
  const int trabecular = DensityMapping::grade_from_density(DensityMapping().density_from_hu(300));
  EXPECT_EQ(grade_at(voxmap, {5.1, 5, 5}), trabecular);
  EXPECT_EQ(grade_at(voxmap, {9.9, 5, 5}), trabecular);
  EXPECT_NE(grade_at(voxmap, {0.2, 5, 5}), trabecular);
}

TEST_F(MeshBone, RadiodensityAboveTheDensestGradeIsWarnedOf) {
  BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {10, 6, 4}), 0.5);
  settings.mesh.cortical_hu = 1727;
  voxmap_from_mesh(settings, report_);
  EXPECT_THAT(report_.warnings, testing::IsEmpty());
  settings.mesh.cortical_hu = 2500;
  voxmap_from_mesh(settings, report_);
  EXPECT_THAT(report_.warnings,
              testing::ElementsAre(HasSubstr("bone.mesh.cortical_hu is 2500 HU, denser than 2 g/cm3 (1727 HU)")));
}

TEST_F(MeshBone, RepairThatCannotWorkIsAnError) {
  // Two fins that meet nowhere: nothing is enclosed.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 5}, {10, 0, 5}, {0, 10, 6}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  BoneSettings settings = settings_for(mesh, 0.5);
  settings.mesh.repair = true;
  EXPECT_THAT(input_error([&] { voxmap_from_mesh(settings, report_); }), HasSubstr("encloses no volume"));
}

TEST_F(MeshBone, FlatMeshEnclosesNothing) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 1}};
  const BoneSettings settings = settings_for(mesh, 0.5);
  EXPECT_THAT(input_error([&] { voxmap_from_mesh(settings, report_); }), HasSubstr("encloses no volume"));
}

TEST_F(MeshBone, SmallerThanAVoxel) {
  const BoneSettings settings = settings_for(box_mesh({0.1, 0.1, 0.1}, {0.2, 0.2, 0.2}), 1);
  EXPECT_THAT(input_error([&] { voxmap_from_mesh(settings, report_); }), HasSubstr("no voxel"));
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
  EXPECT_THAT(input_error([&] { voxmap_from_mesh(settings, report_); }), HasSubstr("would fit"));
  settings.mesh.scale = 1e30;
  settings.voxel_mm = 0.5;
  EXPECT_THAT(input_error([&] { voxmap_from_mesh(settings, report_); }), HasSubstr("would fit"));
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
  const std::string text = input_error([&] { voxmap_from_mesh(settings, report_); });
  const std::string key = "bone.voxel_mm of ";
  const std::size_t at = text.find(key);
  ASSERT_NE(at, std::string::npos) << text;
  const double advised_mm = std::stod(text.substr(at + key.size()));
  EXPECT_GT(advised_mm, 0.3);  // 1000 mm over some 2048 voxels, or fewer on a small machine
  EXPECT_LT(advised_mm, 2.5);
}

TEST_F(MeshBone, UnitThatMakesABoneWithAGlenoidTooSmallOrLargeIsRefused) {
  struct Case {
    double length;
    const char* likely;
  };
  // The file's length, and what the message must advise.
  for (const auto& [length, likely] :
       {Case{0.153, "set bone.mesh.scale: 1000 if the file is in metres (153 mm)"},
        Case{15.3, "set bone.mesh.scale: 10 if the file is in centimetres (153 mm)"},
        Case{6.02, "set bone.mesh.scale: 25.4 if the file is in inches (153 mm)"},
        Case{153000, "set bone.mesh.scale: 0.001 if the file is in micrometres (153 mm)"},
        Case{401, "set bone.mesh.scale: about 0.37 for a scapula of 150 mm"},
        Case{2.78, "set bone.mesh.scale: about 54 for a scapula of 150 mm, 25.4 if the file is in inches"}}) {
    BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {length / 3, length / 4, length}), 0.5);
    settings.side = BodySide::left;
    settings.glenoid.center_mm = Vec3(0, 0, 0);
    const std::string text = input_error([&] { voxmap_from_mesh(settings, report_); });
    EXPECT_THAT(text, HasSubstr("bone.mesh.scale: the mesh is ")) << length;
    EXPECT_THAT(text, HasSubstr("expected 20 to 400 mm for a bone with a glenoid frame")) << length;
    EXPECT_THAT(text, HasSubstr(likely)) << length;
  }
}

TEST_F(MeshBone, UnitAndHolesAreReportedTogetherTheUnitFirst) {
  TriangleMesh mesh = sphere_mesh({0, 0, 0}, 0.07, 3);  // metres
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 64);
  BoneSettings settings = settings_for(mesh, 0.5);
  settings.side = BodySide::left;
  settings.glenoid.near_mm = Vec3(0, 0, 0);
  std::string text;  // two lines
  try {
    voxmap_from_mesh(settings, report_);
  } catch (const InputError& error) {
    text = error.what();
  }
  const std::size_t unit = text.find("set bone.mesh.scale: 1000"), holes = text.find("not a closed surface");
  ASSERT_NE(unit, std::string::npos) << text;
  ASSERT_NE(holes, std::string::npos) << text;
  EXPECT_LT(unit, holes);
  settings.glenoid.near_mm.reset();
  EXPECT_THAT(input_error([&] { voxmap_from_mesh(settings, report_); }), HasSubstr("not a closed surface"));
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("set bone.mesh.scale: 1000")));
}

class MeshFrames : public MeshBone {
 protected:
  /// A box whose header says this.
  BoneSettings settings_with(const std::string& header) const {
    BoneSettings settings = settings_for(box_mesh({-30, -20, 5}, {-10, -10, 25}), 0.5);
    std::fstream file(settings.mesh.path, std::ios::in | std::ios::out | std::ios::binary);
    file.write(header.data(), static_cast<std::streamsize>(header.size()));
    return settings;
  }
  Vec3 centre_of(const BoneSettings& settings) {
    report_ = {};
    const Bone bone = load_bone(settings, report_);
    return bone.voxmap->grid.bounds_mm().center();
  }
};

TEST_F(MeshFrames, AreThatOfTheHeaderOrOfTheKey) {
  const Vec3 as_it_stands(-20, -15, 15), turned(20, 15, 15);
  BoneSettings settings = settings_with("no word of a frame");
  EXPECT_LT((centre_of(settings) - as_it_stands).norm(), 2.5);
  EXPECT_THAT(report_.notes, Contains(HasSubstr("its header states none; the coordinates are taken as they stand")));
  settings.mesh.frame = MeshFrame::ras;
  EXPECT_LT((centre_of(settings) - turned).norm(), 2.5);
  EXPECT_THAT(report_.notes, Contains(HasSubstr("frame of the mesh: RAS, by bone.mesh.frame")));

  settings = settings_with("3D Slicer output. SPACE=RAS");
  EXPECT_LT((centre_of(settings) - turned).norm(), 2.5);
  EXPECT_THAT(report_.notes, Contains(HasSubstr("RAS, as its header says (SPACE=RAS); x and y were negated")));
  settings.mesh.frame = MeshFrame::lps;
  EXPECT_LT((centre_of(settings) - as_it_stands).norm(), 2.5);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("the header of the mesh says SPACE=RAS; the key counts")));

  settings = settings_with("3D Slicer output. SPACE=LPS");
  EXPECT_LT((centre_of(settings) - as_it_stands).norm(), 2.5);
  EXPECT_THAT(report_.notes, Contains(HasSubstr("LPS, as its header says (SPACE=LPS)")));

  settings = settings_with("SPACE=LAS ");
  EXPECT_THAT(input_error([&] { voxmap_from_mesh(settings, report_); }),
              HasSubstr("bone.mesh.frame: the header of the mesh says SPACE=LAS; expected LPS or RAS"));
  settings.mesh.frame = MeshFrame::lps;
  EXPECT_NO_THROW(voxmap_from_mesh(settings, report_));
}

TEST_F(MeshFrames, PointsThatFitAfterAHalfTurnAreSaid) {
  BoneSettings settings = settings_with("");
  settings.side = BodySide::left;
  settings.glenoid.near_mm = Vec3(12, 14, 15);
  voxmap_from_mesh(settings, report_);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("the points of bone.glenoid lie outside the mesh, and would lie")));
  settings.mesh.frame = MeshFrame::ras;
  report_ = {};
  voxmap_from_mesh(settings, report_);
  EXPECT_THAT(report_.warnings, testing::IsEmpty());
}

TEST_F(MeshBone, UnitIsCheckedAfterTheScale) {
  BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {1, 0.5, 2.78}), 0.5);
  settings.glenoid.landmarks = LandmarkSettings{};
  settings.mesh.scale = 55;
  EXPECT_NO_THROW(voxmap_from_mesh(settings, report_));
  settings.mesh.scale = 5;
  EXPECT_THAT(
      input_error([&] { voxmap_from_mesh(settings, report_); }),
      HasSubstr("the mesh is 13.9 mm long, expected 20 to 400 mm for a bone with a glenoid frame; set bone.mesh.scale: "
                "about 54 "
                "for a scapula of 150 mm, 25.4 if the file is in inches (71 mm) or 10 if the file is in centimetres"));
}

TEST_F(MeshBone, WithoutAGlenoidASmallMeshIsOnlyWarnedOf) {
  const BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {1, 1, 2.78}), 0.5);
  EXPECT_GT(voxmap_from_mesh(settings, report_).bone_mm3(), 2);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("the mesh is 2.78 mm long; if that is wrong, set bone.mesh.scale")));
}

TEST_F(MeshBone, RealScapulaInItsOwnUnitIsRefusedWithTheScale) {
  BoneSettings settings;
  settings.mesh.path = data_file("scapula_mesh/scapula_left.stl");
  if (!std::filesystem::exists(settings.mesh.path)) {
    GTEST_SKIP() << "no " << settings.mesh.path << "; set REAMSIM_DATA";
  }
  settings.glenoid.center_mm = Vec3(0, 0, 0);
  const std::string text = input_error([&] { voxmap_from_mesh(settings, report_); });
  const std::string key = "scale: about ";
  ASSERT_THAT(text, HasSubstr(key));
  EXPECT_NEAR(std::stod(text.substr(text.find(key) + key.size())), 55, 0.08 * 55) << text;
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
  const FilledVoxmap voxmap = voxmap_from_mesh(settings, report_);
  EXPECT_NEAR(voxmap.bone_mm3(), truth_mm3, 0.005 * truth_mm3);
  EXPECT_NE(grade_at(voxmap, Vec3(-41.2, 9.2, 36.6) - 5 * Vec3(-0.93, 0.355, -0.08)), 0) << "behind the glenoid";
  EXPECT_EQ(grade_at(voxmap, Vec3(-41.2, 9.2, 36.6) + 5 * Vec3(-0.93, 0.355, -0.08)), 0) << "in front of it";
}

TEST_F(MeshBone, RealDirtyScapula) {
  BoneSettings settings;
  settings.voxel_mm = 0.6;
  settings.mesh.path = data_file("dirty_mesh/scapula_open_nonmanifold.stl");
  settings.mesh.scale = 1000;
  if (!std::filesystem::exists(settings.mesh.path)) {
    GTEST_SKIP() << "no " << settings.mesh.path << "; set REAMSIM_DATA";
  }
  const std::string text = input_error([&] { voxmap_from_mesh(settings, report_); });
  EXPECT_THAT(text, HasSubstr("13 boundary edges (the first at "));
  EXPECT_THAT(text, HasSubstr("23 non-manifold edges"));
  settings.mesh.repair = true;
  const FilledVoxmap voxmap = voxmap_from_mesh(settings, report_);
  EXPECT_GT(voxmap.bone_mm3(), 55e3);
  EXPECT_LT(voxmap.bone_mm3(), 75e3);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("mesh repaired")));
}

TEST_F(MeshFrames, OddFilesOfOtherPrograms) {
  constexpr double kTruth_mm3 = 7187;
  for (const char* name : {"slicer_space_ras.stl", "corners_differ.stl", "upper_case.stl", "count_zero.stl"}) {
    BoneSettings settings;
    settings.source = BoneSource::mesh;
    settings.voxel_mm = 0.4;
    settings.surface_voxels = SurfaceVoxels::partial;
    settings.mesh.path = data_file(std::string("odd_files/") + name);
    if (!std::filesystem::exists(settings.mesh.path)) GTEST_SKIP() << "no " << settings.mesh.path;
    EXPECT_LT((centre_of(settings) - Vec3(10, -20, 30)).norm(), 2.5) << name;
    EXPECT_NEAR(load_bone(settings, report_).view().bone_mm3(), kTruth_mm3, 0.01 * kTruth_mm3) << name;
  }
}

}  // namespace
}  // namespace reamsim::test
