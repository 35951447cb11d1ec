// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include "tests/scenario/scenario_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string kPhantom = "  phantom:\n    shape: half_space\n    size_mm: [10, 10, 6]\n";

class Rules : public ScenarioTest {
 protected:
  std::string changed(const std::string& from, const std::string& to) const {
    return complaint(with(kValid, from, to));
  }
  /// The complaint about a scenario with this bone section (its lines indented by two).
  std::string bone(const std::string& lines) const {
    return changed("  source: phantom\n  voxel_mm: 0.5\n" + kPhantom, lines);
  }
};

TEST_F(Rules, KeysOfAnotherSource) {
  EXPECT_EQ(changed("source: phantom", "source: mesh"),
            "s.yaml:5:3: bone.phantom: does not apply: source is mesh; expected it with source: phantom only");
  EXPECT_EQ(changed("  voxel_mm: 0.5\n", "  mesh: {path: tool.stl}\n"),
            "s.yaml:4:3: bone.mesh: does not apply: source is phantom; expected it with source: mesh only");
}

TEST_F(Rules, SectionOfTheSourceIsNeeded) {
  EXPECT_THAT(bone("  source: ct\n"), StartsWith("s.yaml:2:1: bone.ct: missing; expected"));
  EXPECT_THAT(bone("  source: mesh\n"), StartsWith("s.yaml:2:1: bone.mesh: missing; expected"));
  EXPECT_THAT(bone("  source: vdb\n  vdb: {}\n"), StartsWith("s.yaml:4:3: bone.vdb.path: missing; expected"));
}

TEST_F(Rules, KeysOfAnotherShape) {
  EXPECT_EQ(changed("size_mm: [10, 10, 6]", "radius_mm: 3"),
            "s.yaml:7:5: bone.phantom.radius_mm: does not apply: shape is half_space; expected it with shape: sphere "
            "or cup only");
  EXPECT_THAT(changed("shape: half_space", "shape: sphere"), HasSubstr("bone.phantom.size_mm: does not apply"));
  EXPECT_THAT(changed("size_mm: [10, 10, 6]", "version_deg: 3"), HasSubstr("bone.phantom.version_deg: does not apply"));
}

TEST_F(Rules, KeysOfAnotherWalchType) {
  const auto said = [&](const std::string& keys) {
    return changed(kPhantom, "  side: left\n  phantom: {" + keys + "}\n");
  };
  EXPECT_EQ(said("walch: B2, wear_ridge_mm: 2, wear_tilt_deg: 12"), "");
  EXPECT_THAT(
      said("walch: B2, medialization_mm: 2"),
      HasSubstr("bone.phantom.medialization_mm: does not apply: walch is B2; expected it with walch: A1 or A2 only"));
  EXPECT_THAT(said("wear_radius_mm: 25"), HasSubstr("bone.phantom.wear_radius_mm: does not apply: walch is none"));
  EXPECT_THAT(said("shape: sphere, walch: A1"), HasSubstr("bone.phantom.walch: does not apply: shape is sphere"));
  EXPECT_THAT(said("walch: B3"),
              HasSubstr("bone.phantom.walch: found the text \"B3\"; expected none, A1, A2, B2 or C"));
}

TEST_F(Rules, GeometryOfPhantoms) {
  EXPECT_EQ(changed(kPhantom, "  phantom: {shape: cup, size_mm: [10, 10, 6], radius_mm: 4, cup_depth_mm: 5}\n"),
            "s.yaml:5:61: bone.phantom.cup_depth_mm: found 5; expected no more than radius_mm");
  EXPECT_THAT(
      changed(kPhantom, "  phantom: {shape: cup, size_mm: [10, 10, 6], radius_mm: 20, cup_depth_mm: 4}\n"),
      HasSubstr("bone.phantom.radius_mm: found 20; expected a cup whose opening (radius 12 mm) fits the block"));
  EXPECT_THAT(changed(kPhantom, "  phantom: {shape: layered, size_mm: [10, 10, 6], cortical_mm: 6}\n"),
              HasSubstr("bone.phantom.cortical_mm: found 6; expected less than the block's height"));
  EXPECT_THAT(changed(kPhantom, "  side: left\n  phantom: {shape: glenoid, width_mm: 36}\n"),
              HasSubstr("bone.phantom.width_mm: found 36; expected less than height_mm"));
}

TEST_F(Rules, SideIsNeededWithAGlenoid) {
  EXPECT_EQ(changed(kPhantom, "  phantom: {shape: glenoid}\n"),
            "s.yaml:2:1: bone.side: missing; expected left or right, because bone.phantom.shape is glenoid");
  EXPECT_EQ(changed(kPhantom, ""),  // glenoid is the default shape
            "s.yaml:2:1: bone.side: missing; expected left or right, because bone.phantom.shape is glenoid");
  EXPECT_EQ(changed(kPhantom, kPhantom + "  glenoid: {center_mm: [0, 0, 0], normal: [0, 0, 1], superior: [0, 1, 0]}\n"),
            "s.yaml:2:1: bone.side: missing; expected left or right, because bone.glenoid is given");
  EXPECT_EQ(changed(kPhantom, "  side: left\n  phantom: {shape: glenoid}\n"), "");
}

TEST_F(Rules, GlenoidFrameIsNeeded) {
  const std::string mesh = "  source: mesh\n  side: left\n  mesh: {path: tool.stl}\n";
  EXPECT_EQ(
      complaint(with(with(kValid, "  source: phantom\n  voxel_mm: 0.5\n" + kPhantom, mesh), "motion:\n",
                     "motion:\n  frame: glenoid\n")),
      "s.yaml:9:3: motion.frame: frame is glenoid but bone.glenoid is missing; expected bone.glenoid, or frame: bone");
  EXPECT_THAT(bone(mesh + "  pilot_hole: {frame: glenoid}\n"),
              HasSubstr("bone.pilot_hole.frame: frame is glenoid but bone.glenoid is missing"));
  EXPECT_EQ(changed(kPhantom, kPhantom + "  side: left\n  pilot_hole: {frame: glenoid}\n"), "")
      << "a phantom has its own";
}

TEST_F(Rules, TheRimGoesOnceRoundAFace) {
  const auto rim = [&](const std::string& points) {
    return changed(kPhantom, kPhantom + "  glenoid: {rim_mm: [" + points + "]}\n");
  };
  EXPECT_EQ(rim("[13, 0, 0], [9, 9, 1], [0, 17, 0], [-9, 9, 1], [-13, 0, 0], [0, -17, 0]"), "");
  EXPECT_EQ(rim("[13, 0, 0], [0, -17, 0], [-13, 0, 0], [-9, 9, 1], [0, 17, 0], [9, 9, 1]"), "") << "either way round";
  EXPECT_THAT(
      rim("[13, 0, 0], [9, 9, 1], [0, 17, 0], [-9, 9, 1], [-13, 0, 0]"),
      HasSubstr("bone.glenoid.rim_mm: found a list of 5; expected a list of 6 or more points [[x, y, z], ...]"));
  EXPECT_THAT(rim("[13, 0, 0], [9, 9], [0, 17, 0], [-9, 9, 1], [-13, 0, 0], [0, -17, 0]"),
              HasSubstr("bone.glenoid.rim_mm: found a list of 2"));
  EXPECT_THAT(rim("[13, 0, 0], [0, 17, 0], [9, 9, 1], [-9, 9, 1], [-13, 0, 0], [0, -17, 0]"),
              HasSubstr("bone.glenoid.rim_mm: found point 3 out of order"));
  EXPECT_THAT(rim("[13, 0, 0], [9, 9, 1], [9, 9, 1], [0, 17, 0], [-13, 0, 0], [0, -17, 0]"),
              HasSubstr("bone.glenoid.rim_mm: found point 3 out of order"));
  EXPECT_THAT(rim("[13, 0, 0], [9, 0, 0], [0, 0, 0], [-9, 0, 0], [-13, 0, 0], [-20, 0, 0]"),
              HasSubstr("bone.glenoid.rim_mm: found points on one line"));
  EXPECT_THAT(rim("[1.3, 0, 0], [0.9, 0.9, 1], [0, 1.7, 0], [-0.9, 0.9, 0], [-1.3, 0, 0], [0, -1.7, 0]"),
              HasSubstr("bone.glenoid.rim_mm: found a rim 3.4 mm long"));
}

TEST_F(Rules, GlenoidFrameIsWhole) {
  const auto glenoid = [&](const std::string& keys) {
    return changed(kPhantom, kPhantom + "  side: left\n  glenoid: {" + keys + "}\n");
  };
  EXPECT_EQ(glenoid("center_mm: [0, 0, 0], normal: [0, 0, 1]"),
            "s.yaml:9:3: bone.glenoid.superior: missing; expected center_mm, normal and superior together");
  EXPECT_EQ(glenoid("center_mm: [0, 0, 0], normal: [0, 0, 1], superior: [0, 0, -2]"),
            "s.yaml:9:54: bone.glenoid.superior: found the direction of normal; expected a direction across it");
  EXPECT_THAT(glenoid("center_mm: [0, 0, 0], normal: [0, 0, 0], superior: [0, 1, 0]"),
              HasSubstr("s.yaml:9:43: bone.glenoid.normal: found a direction of length 0"));
  const std::string marks =
      "landmarks: {glenoid_center_mm: [0, 0, 0], trigonum_spinae_mm: [90, 0, 0], inferior_angle_mm: ";
  EXPECT_EQ(glenoid(marks + "[80, -120, 0]}"), "");
  EXPECT_EQ(glenoid(marks + "[45, 0, 0]}"),
            "s.yaml:9:13: bone.glenoid.landmarks: found three points on one line or closer than 1 mm; expected three "
            "points that span a plane");
  EXPECT_EQ(
      glenoid("center_mm: [0, 0, 0], " + marks + "[80, -120, 0]}"),
      "s.yaml:9:13: bone.glenoid.center_mm: given together with landmarks; expected one of landmarks or center_mm");
}

TEST_F(Rules, ThePlaneOfTheFaceNeedsThreePoints) {
  EXPECT_THAT(changed(kPhantom, kPhantom + "  glenoid: {version_landmarks: {face_mm: [[0, 0, 0], [1, 0, 0]]}}\n"),
              HasSubstr("found a list of 2; expected a list of 3 or more"));
}

TEST_F(Rules, ImplicitKnowsTheSweptSurfaceOnly) {
  const std::string implicit = "engine: {type: implicit}\n";
  EXPECT_EQ(complaint(kValid + implicit), "");
  EXPECT_EQ(complaint(kValid + implicit + "cutting: {law: per_point}\n"),
            "s.yaml:17:11: cutting.law: found per_point; expected energy, because engine.type is implicit");
  EXPECT_EQ(complaint(with(kValid, "  mesh: tool.stl\n", "  mesh: tool.stl\n  spin: resolved\n") + implicit),
            "s.yaml:10:3: tool.spin: found resolved; expected envelope, because engine.type is implicit");
  for (const char* engine : {"bricked", "direct", "octree"}) {
    EXPECT_EQ(complaint(kValid + "engine: {type: " + engine + "}\ncutting: {law: per_point}\n"), "");
  }
}

TEST_F(Rules, ExactClipsTeethThatTurn) {
  const std::string resolved = with(kValid, "  mesh: tool.stl\n", "  mesh: tool.stl\n  spin: resolved\n");
  EXPECT_EQ(parse(resolved).cutting.erosion, ErosionMode::exact);
  EXPECT_EQ(complaint(resolved + "cutting: {erosion: exact}\n"), "");
  EXPECT_EQ(complaint(resolved + "cutting: {edge_force: {tangential_n_mm: 1, normal_n_mm: 1, cutting_edges: 6}}\n"),
            "s.yaml:10:3: tool.spin: found resolved; expected envelope, because cutting.edge_force is given");
}

TEST_F(Rules, AnImplantFitsOnItsOwnRadius) {
  EXPECT_EQ(complaint(kValid + "metrics: {dense_g_cm3: 0.9, implant: {backside_radius_mm: 20, diameter_mm: 40}}\n"),
            "");
  EXPECT_EQ(complaint(kValid + "metrics: {implant: {backside_radius_mm: 0, diameter_mm: 40}}\n"), "") << "flat";
  EXPECT_EQ(complaint(kValid + "metrics: {implant: {backside_radius_mm: 20, diameter_mm: 41}}\n"),
            "s.yaml:16:45: metrics.implant.diameter_mm: found 41; expected no more than twice backside_radius_mm");
}

TEST_F(Rules, AnImplantHasAFootprintAFrameAndPegs) {
  const auto implant = [&](const std::string& keys) {
    return complaint(kValid + "metrics: {implant: {backside_radius_mm: 20, " + keys + "}}\n");
  };
  EXPECT_EQ(implant("width_mm: 26, height_mm: 36, footprint: pear, axis: [0.2, 0, 1], superior: [0, 1, 0], "
                    "augment: {angle_deg: 15, direction: [-1, 0, 3]}, "
                    "pegs: [{from_mm: [0, 0, 0], to_mm: [0, 0, -12], diameter_mm: 6}]"),
            "");
  EXPECT_EQ(implant("width_mm: 26"),
            "s.yaml:16:11: metrics.implant.height_mm: missing; expected width_mm and height_mm together");
  EXPECT_EQ(implant("height_mm: 26"),
            "s.yaml:16:11: metrics.implant.width_mm: missing; expected width_mm and height_mm together");
  EXPECT_THAT(
      implant("diameter_mm: 20, width_mm: 26, height_mm: 30"),
      HasSubstr("metrics.implant.diameter_mm: found diameter_mm beside width_mm or height_mm; expected either"));
  EXPECT_THAT(implant("width_mm: 26, height_mm: 25, footprint: pear"),
              HasSubstr("metrics.implant.height_mm: found 25; expected at least width_mm, because footprint is pear"));
  EXPECT_THAT(implant("width_mm: 26, height_mm: 41"),
              HasSubstr("metrics.implant.height_mm: found 41; expected no more than twice backside_radius_mm"));
  EXPECT_THAT(implant("axis: [1, 0, 0]"), HasSubstr("metrics.implant.axis: found an axis with z ≤ 0"));
  EXPECT_EQ(implant("axis: [1, 0, 0], frame: bone"), "");
  EXPECT_THAT(implant("axis: [0, 1, 2], superior: [0, 2, 4]"),
              HasSubstr("metrics.implant.superior: found a direction along axis"));
  EXPECT_THAT(implant("augment: {angle_deg: 15, direction: [0, 0, 1]}"),
              HasSubstr("metrics.implant.augment.direction: found x = y = 0"));
  EXPECT_EQ(implant("augment: {shape: step, step_mm: 5}"), "");
  EXPECT_THAT(implant("augment: {shape: step}"), HasSubstr("metrics.implant.augment.step_mm: missing"));
  EXPECT_THAT(implant("augment: {shape: step, step_mm: 5, angle_deg: 15}"),
              HasSubstr("metrics.implant.augment.angle_deg: does not apply: shape is step"));
  EXPECT_EQ(implant("mesh: {path: tool.stl, scale: 10, pegs_below_mm: 2}"), "");
  EXPECT_THAT(implant("mesh: {path: nix.stl}"), HasSubstr("metrics.implant.mesh.path: no such file"));
  for (const std::string key : {"diameter_mm: 20", "augment: {angle_deg: 15}", "footprint: pear"}) {
    EXPECT_THAT(implant("mesh: {path: tool.stl}, " + key), HasSubstr("mesh is given; expected one or the other"));
  }
  EXPECT_THAT(implant("pegs: [{from_mm: [1, 0, 0], to_mm: [1, 0, 0.05], diameter_mm: 3}]"),
              HasSubstr("metrics.implant.pegs.0.to_mm: found a point closer than 0.1 mm to from_mm"));
}

TEST_F(Rules, TheFrameOfAnImplantIsKnown) {
  const std::string implant = "metrics: {implant: {backside_radius_mm: 20, frame: glenoid}}\n";
  EXPECT_EQ(complaint(kValid + implant), "");
  const std::string mesh = with(kValid, "  source: phantom\n", "  source: mesh\n  mesh: {path: tool.stl}\n");
  EXPECT_THAT(complaint(mesh + implant),
              HasSubstr("metrics.implant.frame: frame is glenoid but bone.glenoid is missing"));
}

TEST_F(Rules, ValuesOfMetrics) {
  const auto metrics = [&](const std::string& keys) { return complaint(kValid + "metrics: {" + keys + "}\n"); };
  EXPECT_EQ(metrics("implant: {}"),
            "s.yaml:16:11: metrics.implant.backside_radius_mm: missing; expected this key: Radius of the spherical "
            "back; 0: flat");
  EXPECT_THAT(metrics("implant: 25"), HasSubstr("s.yaml:16:20: metrics.implant: found 25; expected a section"));
  EXPECT_THAT(metrics("implant: {backside_radius_mm: -1}"), HasSubstr("metrics.implant.backside_radius_mm: found -1"));
  EXPECT_THAT(metrics("implant: {backside_radius_mm: big}"), HasSubstr("metrics.implant.backside_radius_mm: found"));
  EXPECT_THAT(metrics("implant: {backside_radius_mm: 9, gap_mm: 0}"), HasSubstr("metrics.implant.gap_mm: found 0"));
  EXPECT_THAT(metrics("dense_g_cm3: 0"), HasSubstr("metrics.dense_g_cm3: found 0"));
  EXPECT_THAT(metrics("dense_g_cm3: 2.5"), HasSubstr("metrics.dense_g_cm3: found 2.5"));
  EXPECT_THAT(metrics("dense_hu: 800"), HasSubstr("s.yaml:16:11: metrics.dense_hu: unknown key"));
}

TEST_F(Rules, OneMotion) {
  EXPECT_EQ(changed("motion:\n", "motion:\n  plunge: {feed_mm_s: 1}\n"),
            "s.yaml:12:3: motion.keyframes: given together with plunge; expected one of plunge, push, passes, "
            "keyframes or csv");
  EXPECT_EQ(complaint(kValid.substr(0, kValid.find("motion:")) + "motion: {frame: bone}\n"),
            "s.yaml:10:1: motion: needs either plunge, push, passes, keyframes or csv");
}

TEST_F(Rules, Keyframes) {
  EXPECT_EQ(
      changed("time_s: 1", "time_s: 0"),
      "s.yaml:13:8: motion.keyframes.1.time_s: found 0; expected a time later than that of the previous keyframe, 0 s");
  EXPECT_EQ(changed(", axis: [0, 0, 1]}\n", "}\n"), "s.yaml:12:7: motion.keyframes.0: needs either axis or quaternion");
  EXPECT_EQ(
      changed("axis: [0, 0, 1]}\n", "axis: [0, 0, 1], quaternion: [1, 0, 0, 0]}\n"),
      "s.yaml:12:60: motion.keyframes.0.quaternion: given together with axis; expected one of axis or quaternion");
  EXPECT_EQ(changed("axis: [0, 0, 1]}\n", "quaternion: [1, 1, 0, 0]}\n"),
            "s.yaml:12:55: motion.keyframes.0.quaternion: found 4 numbers of length 1.4142135623730951; expected 4 "
            "numbers [w, x, y, z] of length 1");
  EXPECT_EQ(
      changed("axis: [0, 0, 1]}\n", "axis: [0, 0, 0]}\n"),
      "s.yaml:12:49: motion.keyframes.0.axis: found a direction of length 0; expected 3 numbers [x, y, z], not all "
      "zero, each -1000 to 1000");
  EXPECT_EQ(complaint(kValid.substr(0, kValid.find("motion:")) + "motion:\n  keyframes: []\n"),
            "s.yaml:11:3: motion.keyframes: found a list of 0; expected two or more keyframes");
}

TEST_F(Rules, RunsThatNeverEnd) {
  EXPECT_EQ(
      changed("time_s: 1", "time_s: 100000"),
      "s.yaml:11:3: motion.keyframes: takes 100000 s, 100000000 frames at frame_rate_hz; expected at most 10000000 "
      "frames");
}

TEST_F(Rules, Crop) {
  write("scan.nrrd", "NRRD0004\n");
  EXPECT_EQ(bone("  source: ct\n  ct: {path: scan.nrrd, crop_min_mm: [0, 0, 0]}\n"),
            "s.yaml:4:3: bone.ct.crop_max_mm: missing; expected crop_min_mm and crop_max_mm together");
  EXPECT_EQ(bone("  source: ct\n  ct: {path: scan.nrrd, crop_min_mm: [0, 0, 0], crop_max_mm: [5, 5, 0]}\n"),
            "s.yaml:4:49: bone.ct.crop_max_mm: found a corner that is not greater than crop_min_mm on every axis; "
            "expected a larger x, y and z");
}

TEST_F(Rules, LabelMapReplacesSegmentation) {
  write("scan.nrrd", "NRRD0004\n");
  EXPECT_EQ(bone("  source: ct\n  ct: {path: scan.nrrd, label_map: {path: scan.nrrd}, threshold_hu: 3}\n"),
            "s.yaml:4:55: bone.ct.threshold_hu: does not apply: label_map is given; expected one or the other");
  EXPECT_EQ(bone("  source: ct\n  ct: {path: scan.nrrd, label_map: {path: scan.nrrd}}\n"), "");
}

TEST_F(Rules, LabelsAreNamesOrWholeNumbers) {
  write("scan.nrrd", "NRRD0004\n");
  const auto label = [&](const std::string& text) {
    return bone("  source: ct\n  ct: {path: scan.nrrd, label_map: {path: scan.nrrd, label: " + text + "}}\n");
  };
  for (const char* fine : {"3", "scapula_left", "[scapula_left, 3]", "\"3\""}) EXPECT_EQ(label(fine), "") << fine;
  const std::string expected = "expected a name or a whole number, or a list of them";
  for (const char* wrong : {"1.5", "-1", "[]", "[1.5]", "{a: 1}", "[[1]]", "\"\""}) {
    EXPECT_THAT(label(wrong), StartsWith("s.yaml:4:")) << wrong;
    EXPECT_THAT(label(wrong), ::testing::HasSubstr("bone.ct.label_map.label: found ")) << wrong;
  }
  EXPECT_THAT(label("1.5"), ::testing::HasSubstr(expected));
  EXPECT_EQ(bone("  source: ct\n  ct: {path: scan.nrrd, series: 1.2.840.113619.2}\n"), "");
  EXPECT_EQ(bone("  source: ct\n  ct: {path: scan.nrrd, series: 2}\n"), "");
  EXPECT_THAT(bone("  source: ct\n  ct: {path: scan.nrrd, modality: MR}\n"), ::testing::HasSubstr("ct or any"));
}

TEST_F(Rules, FilesMustBeThere) {
  EXPECT_EQ(changed("tool.stl", "nix.stl"),
            "s.yaml:9:9: tool.mesh: no such file: nix.stl; expected a file that exists");
  std::filesystem::create_directory(path("folder"));
  EXPECT_EQ(changed("tool.stl", "folder"), "s.yaml:9:9: tool.mesh: folder is a folder; expected a file");
  EXPECT_EQ(bone("  source: ct\n  ct: {path: folder}\n"), "") << "a DICOM folder";
  EXPECT_EQ(bone("  source: vdb\n  vdb: {path: folder}\n"),
            "s.yaml:4:15: bone.vdb.path: folder is a folder; expected a file");
  EXPECT_EQ(changed("tool.stl", "/dev/null"),
            "s.yaml:9:9: tool.mesh: /dev/null is a pipe, a device or a socket; expected a file on a disk");
}

TEST_F(Rules, VariablesInPaths) {
  ::unsetenv("REAMSIM_TEST_UNSET");
  EXPECT_EQ(
      changed("tool.stl", "${REAMSIM_TEST_UNSET}/tool.stl"),
      "s.yaml:9:9: tool.mesh: the environment variable REAMSIM_TEST_UNSET in \"${REAMSIM_TEST_UNSET}/tool.stl\" is "
      "not set; expected it to name a folder or file (export REAMSIM_TEST_UNSET=...)");
  EXPECT_THAT(changed("tool.stl", "\"${not closed\""), StartsWith("s.yaml:9:9: tool.mesh: found \"${not closed\""));
  EXPECT_THAT(changed("tool.stl", "\"${a b}\""), StartsWith("s.yaml:9:9: tool.mesh: found \"${a b}\""));
  ::setenv("REAMSIM_TEST_DIR", dir_.c_str(), 1);
  EXPECT_EQ(parse(with(kValid, "tool.stl", "${REAMSIM_TEST_DIR}/./tool.stl")).tool.mesh, path("tool.stl"));
  ::unsetenv("REAMSIM_TEST_DIR");
  write("${x}.stl", "solid\n");
  EXPECT_EQ(parse(with(kValid, "tool.stl", "$${x}.stl")).tool.mesh, path("${x}.stl"));
}

TEST_F(Rules, PathsAreRelativeToTheScenario) {
  const Scenario s = parse(kValid + "output:\n  dir: ../results/\n");
  EXPECT_EQ(s.tool.mesh, path("tool.stl"));
  EXPECT_EQ(s.output.dir, std::filesystem::path(dir_).parent_path().string() + "/results");
  EXPECT_EQ(s.file, path("s.yaml"));
  EXPECT_EQ(s.name, "s");
}

}  // namespace
}  // namespace reamsim::test
