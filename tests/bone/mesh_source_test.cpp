// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Frame, unit and state of a mesh.
#include <filesystem>
#include <fstream>

#include "mesh_bone_fixture.h"
#include "sim/scene/load_bone.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

TEST_F(MeshBone, InsideOutIsTurnedAndSaid) {
  const BoneSettings settings = settings_for(inside_out(sphere_mesh({0, 0, 0}, 8, 3)), 0.5);
  const double truth_mm3 = sphere_mesh({0, 0, 0}, 8, 3).volume_mm3();
  EXPECT_NEAR(load(settings).bone_mm3(), truth_mm3, 0.01 * truth_mm3);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("face inwards")));
}

TEST_F(MeshBone, OpenMeshIsRefusedUntilRepairIsAskedFor) {
  TriangleMesh mesh = sphere_mesh({0, 0, 0}, 8, 3);
  const double truth_mm3 = mesh.volume_mm3();
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 16);
  BoneSettings settings = settings_for(mesh, 0.4);
  const std::string text = refusal(settings);
  EXPECT_THAT(text, HasSubstr(settings.mesh.path));
  EXPECT_THAT(text, HasSubstr("boundary edges (the first at "));
  EXPECT_THAT(text, HasSubstr("1 hole, "));
  EXPECT_THAT(text, HasSubstr("bone.mesh.repair"));
  settings.mesh.repair = true;
  EXPECT_NEAR(load(settings).bone_mm3(), truth_mm3, 0.01 * truth_mm3);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("1 holes closed")));
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("volume of the mesh by winding numbers: ")));
}

TEST_F(MeshBone, ARepairThatChangesTheVolumeIsRefusedUnlessAskedFor) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {20, 20, 20});
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 6);  // three faces of six
  BoneSettings settings = settings_for(mesh, 0.5);
  settings.mesh.repair = true;
  const std::string text = refusal(settings);
  EXPECT_THAT(text, HasSubstr("bone.mesh.repair: closing the holes would change the volume by more than 1 %: "));
  EXPECT_THAT(text, HasSubstr("bone.mesh.repair_change_percent: "));
  settings.mesh.repair_change_percent = 1000;
  EXPECT_GT(load(settings).bone_mm3(), 100);
}

TEST_F(MeshBone, APieceBesidesTheBoneIsNamed) {
  const TriangleMesh bone = box_mesh({0, 0, 0}, {10, 10, 10});
  load(settings_for(joined({box_mesh({20, 2, 4}, {22, 6, 6}), bone}), 0.5));
  EXPECT_THAT(report_.warnings,
              testing::ElementsAre("the mesh has a piece besides the largest: 16 mm3 at (21.0, 4.0, 5.0) mm; all are "
                                   "kept as bone: remove in the mesh what is no bone"));
  report_ = {};
  load(settings_for(joined({bone, box_mesh({3, 3, 3}, {6, 6, 6})}), 0.5));
  EXPECT_THAT(report_.warnings,
              testing::ElementsAre("the mesh has a surface inside another; a surface inside another does not create a "
                                   "cavity"));
}

TEST_F(MeshBone, EachPieceThatFacesInwardsIsTurnedAndSaid) {
  const TriangleMesh bone = box_mesh({0, 0, 0}, {10, 10, 10}), other = box_mesh({20, 0, 0}, {28, 8, 8});
  EXPECT_DOUBLE_EQ(load(settings_for(joined({bone, inside_out(other)}), 0.5)).bone_mm3(), 1512);
  EXPECT_THAT(report_.warnings,
              testing::ElementsAre("the triangles of a piece of the mesh face inwards: 512 mm3 at (24.0, 4.0, 4.0) mm; "
                                   "orientation flipped",
                                   HasSubstr("a piece besides the largest: 512 mm3")));
  report_ = {};
  const TriangleMesh twin = box_mesh({20, 0, 0}, {30, 10, 10});
  EXPECT_DOUBLE_EQ(load(settings_for(joined({bone, inside_out(twin)}), 0.5)).bone_mm3(), 2000)
      << "the signed volumes add up to 0";
}

TEST_F(MeshBone, TheRepairTurnsAPieceOfWhichMostFacesInwards) {
  TriangleMesh other = box_mesh({20, 0, 0}, {28, 8, 8});
  for (std::size_t i = 0; i < 8; ++i) std::swap(other.triangles[i][1], other.triangles[i][2]);
  BoneSettings settings = settings_for(joined({box_mesh({0, 0, 0}, {10, 10, 10}), other}), 0.5);
  settings.mesh.repair = true;
  EXPECT_DOUBLE_EQ(load(settings).bone_mm3(), 1512);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("4 triangles turned")));
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("a piece of the mesh face inwards: 512 mm3")));
}

TEST_F(MeshBone, TrianglesOfMixedOrientationAreTurnedByTheRepair) {
  TriangleMesh mesh = sphere_mesh({0, 0, 0}, 8, 3);
  const double truth_mm3 = mesh.volume_mm3();
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
  BoneSettings settings = settings_for(mesh, 0.4);
  EXPECT_THAT(refusal(settings),
              testing::AllOf(HasSubstr("no consistent orientation"), HasSubstr("bone.mesh.repair: true, which turns")));
  settings.mesh.repair = true;
  EXPECT_NEAR(load(settings).bone_mm3(), truth_mm3, 0.01 * truth_mm3);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("triangles turned")));
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
    const std::string text = refusal(settings);
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
    load(settings);
  } catch (const InputError& error) {
    text = error.what();
  }
  const std::size_t unit = text.find("set bone.mesh.scale: 1000"), holes = text.find("not a closed surface");
  ASSERT_NE(unit, std::string::npos) << text;
  ASSERT_NE(holes, std::string::npos) << text;
  EXPECT_LT(unit, holes);
  settings.glenoid.near_mm.reset();
  EXPECT_THAT(refusal(settings), HasSubstr("not a closed surface"));
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
  EXPECT_THAT(refusal(settings),
              HasSubstr("bone.mesh.frame: the header of the mesh says SPACE=LAS; expected LPS or RAS"));
  settings.mesh.frame = MeshFrame::lps;
  EXPECT_NO_THROW(load(settings));
}

TEST_F(MeshFrames, PointsThatFitAfterAHalfTurnAreSaid) {
  BoneSettings settings = settings_with("");
  settings.side = BodySide::left;
  settings.glenoid.near_mm = Vec3(12, 14, 15);
  load(settings);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("the points of bone.glenoid lie outside the mesh, and would lie")));
  settings.mesh.frame = MeshFrame::ras;
  report_ = {};
  load(settings);
  EXPECT_THAT(report_.warnings, testing::IsEmpty());
}

TEST_F(MeshBone, UnitIsCheckedAfterTheScale) {
  BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {1, 0.5, 2.78}), 0.5);
  settings.glenoid.landmarks = LandmarkSettings{};
  settings.mesh.scale = 55;
  EXPECT_NO_THROW(load(settings));
  settings.mesh.scale = 5;
  EXPECT_THAT(
      refusal(settings),
      HasSubstr("the mesh is 13.9 mm long, expected 20 to 400 mm for a bone with a glenoid frame; set bone.mesh.scale: "
                "about 54 "
                "for a scapula of 150 mm, 25.4 if the file is in inches (71 mm) or 10 if the file is in centimetres"));
}

TEST_F(MeshBone, WithoutAGlenoidASmallMeshIsOnlyWarnedOf) {
  const BoneSettings settings = settings_for(box_mesh({0, 0, 0}, {1, 1, 2.78}), 0.5);
  EXPECT_GT(load(settings).bone_mm3(), 2);
  EXPECT_THAT(report_.warnings, Contains(HasSubstr("the mesh is 2.78 mm long; if that is wrong, set bone.mesh.scale")));
}

TEST_F(MeshBone, RealScapulaInItsOwnUnitIsRefusedWithTheScale) {
  BoneSettings settings;
  settings.mesh.path = data_file("scapula_mesh/scapula_left.stl");
  if (!std::filesystem::exists(settings.mesh.path)) {
    GTEST_SKIP() << "no " << settings.mesh.path << "; set REAMSIM_DATA";
  }
  settings.glenoid.center_mm = Vec3(0, 0, 0);
  const std::string text = refusal(settings);
  const std::string key = "scale: about ";
  ASSERT_THAT(text, HasSubstr(key));
  EXPECT_NEAR(std::stod(text.substr(text.find(key) + key.size())), 55, 0.08 * 55) << text;
}

TEST_F(MeshBone, RealDirtyScapula) {
  BoneSettings settings;
  settings.voxel_mm = 0.6;
  settings.mesh.path = data_file("dirty_mesh/scapula_open_nonmanifold.stl");
  settings.mesh.scale = 1000;
  if (!std::filesystem::exists(settings.mesh.path)) {
    GTEST_SKIP() << "no " << settings.mesh.path << "; set REAMSIM_DATA";
  }
  const std::string text = refusal(settings);
  EXPECT_THAT(text, HasSubstr("13 boundary edges (the first at "));
  EXPECT_THAT(text, HasSubstr("23 non-manifold edges"));
  settings.mesh.repair = true;
  const FilledVoxmap voxmap = load(settings);
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

TEST_F(MeshBone, ASurfaceThatEnclosesNothingIsRefused) {
  TriangleMesh fins;  // two that meet nowhere
  fins.vertices = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 5}, {10, 0, 5}, {0, 10, 6}};
  fins.triangles = {{0, 1, 2}, {3, 4, 5}};
  BoneSettings settings = settings_for(fins, 0.5);
  settings.mesh.repair = true;
  EXPECT_THAT(refusal(settings), HasSubstr("encloses no volume"));
  TriangleMesh flat;
  flat.vertices = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}};
  flat.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_THAT(refusal(settings_for(flat, 0.5)), HasSubstr("encloses no volume"));
}

}  // namespace
}  // namespace reamsim::test
