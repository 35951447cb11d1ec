// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include <random>

#include "sim/scenario/show.h"
#include "tests/scenario/scenario_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class RoundTrip : public ScenarioTest {
 protected:
  /// The resolved text of the scenario, after checking that it parses to the same again.
  std::string resolved(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
    const std::string once = to_yaml(parse(yaml, overrides));
    const std::string twice = to_yaml(parse(once));
    EXPECT_EQ(once, twice);
    return once;
  }
};

TEST_F(RoundTrip, EveryDefaultIsFilledIn) {
  const std::string yaml = resolved(kValid);
  for (const char* line : {"name: s\n", "  density:\n    ash_slope_g_cm3_per_hu: 0.0007\n", "    density_g_cm3: 1.8\n",
                           "  frame_rate_hz: 1000\n", "  type: auto\n", "  cameras: [oblique, glenoid, section]\n",
                           "  dir: \"\"\n", "    - time_s: 0\n      position_mm: [0, 0, 1]\n", "      spin_rpm: 0\n"}) {
    EXPECT_THAT(yaml, HasSubstr(line));
  }
  EXPECT_THAT(yaml, HasSubstr("  mesh: " + path("tool.stl") + "\n"));
  EXPECT_THAT(yaml, Not(HasSubstr("plunge"))) << "not given";
  EXPECT_THAT(yaml, Not(HasSubstr("radius_mm"))) << "does not apply to a half-space";
}

TEST_F(RoundTrip, EveryPhantom) {
  const std::string sized = "  phantom:\n    shape: half_space\n    size_mm: [10, 10, 6]\n";
  for (const std::string phantom :
       {"{shape: cup, size_mm: [10, 10, 6], radius_mm: 5, cup_depth_mm: 2}",
        "{shape: sphere, density_g_cm3: 0.123456789}", "{shape: layered, size_mm: [10, 10, 6]}",
        "{shape: glenoid, version_deg: -12.5, seed: 7}", "{walch: A1}", "{walch: B2, wear_tilt_deg: 20}",
        "{walch: C, rim_rounding_mm: 5}", "{}"}) {
    EXPECT_THAT(resolved(with(kValid, sized, "  side: right\n  phantom: " + phantom + "\n")),
                HasSubstr("  phantom:\n"));
  }
}

TEST_F(RoundTrip, WalchTypeBringsItsDefaults) {
  const std::string sized = "  phantom:\n    shape: half_space\n    size_mm: [10, 10, 6]\n";
  const auto yaml = [&](const std::string& phantom) {
    return resolved(with(kValid, sized, "  side: right\n  phantom: " + phantom + "\n"));
  };
  const std::string healthy = yaml("{}");
  EXPECT_THAT(healthy, HasSubstr("    walch: none\n    height_mm: 35\n"));
  EXPECT_THAT(healthy, HasSubstr("    version_deg: 0\n"));
  EXPECT_THAT(healthy, Not(HasSubstr("wear_radius_mm")));
  const std::string dysplastic = yaml("{walch: C}");
  EXPECT_THAT(dysplastic, HasSubstr("    walch: C\n    height_mm: 46\n"));
  EXPECT_THAT(dysplastic, HasSubstr("    version_deg: 37\n"));
  // What the scenario gives stands, wherever it is given.
  const std::string own = yaml("{version_deg: 12, walch: A2, medialization_mm: 4}");
  EXPECT_THAT(own, HasSubstr("    version_deg: 12\n    inclination_deg: 8\n    medialization_mm: 4\n"));
}

TEST_F(RoundTrip, Metrics) {
  EXPECT_THAT(resolved(kValid), HasSubstr("metrics:\n  dense_g_cm3: 1\n"));
  EXPECT_THAT(resolved(kValid, {"metrics.implant.backside_radius_mm=27.5"}),
              HasSubstr("  implant:\n    backside_radius_mm: 27.5\n    diameter_mm: 0\n    gap_mm: 0.5\n"));
}

TEST_F(RoundTrip, EverySource) {
  write("scan.nrrd", "x");
  const std::string phantom =
      "  source: phantom\n  voxel_mm: 0.5\n  phantom:\n    shape: half_space\n    size_mm: [10, 10, 6]\n";
  const std::string glenoid =
      "  side: left\n  glenoid: {center_mm: [1.1, 2, 3], normal: [0.611, -0.548, 0.572], superior: [0, 0, 1],\n"
      "    rim_mm: [[13.5, 0, 0], [9, 9, 1], [0, 17, 0], [-9, 9, 1], [-13, 0, 0], [0, -17, 0]]}\n"
      "  pilot_hole: {frame: glenoid, depth_mm: 30}\n";
  for (const std::string source :
       {"  source: mesh\n  mesh: {path: tool.stl, scale: 55, repair: true}\n",
        "  source: vdb\n  vdb: {path: scan.nrrd}\n",
        "  source: ct\n  ct: {path: scan.nrrd, seed_mm: [1, 2, 3], crop_min_mm: [0, 0, 0], crop_max_mm: [9, 9, 9],\n"
        "    cut_spheres: [{center_mm: [139.2, 163.7, -427.7], radius_mm: 21.8}, {center_mm: [0, 0, 0], radius_mm: "
        "1}],\n"
        "    cut_planes: [{point_mm: [1, 2, 3], normal: [0, 1, 0]}], fill_holes: false}\n",
        "  source: ct\n  ct: {path: scan.nrrd, label_map: {path: scan.nrrd, label: 3}}\n",
        "  source: ct\n  ct: {path: scan.nrrd, series: 2, modality: any, uneven: resample,\n"
        "    label_map: {path: scan.nrrd, label: [7, \"scapula: left\", \"8\"], refine_mm: 1}}\n"}) {
    const Scenario s = parse(resolved(with(kValid, phantom, source + glenoid)));
    EXPECT_EQ(*s.bone.glenoid.normal, Vec3(0.611, -0.548, 0.572));
    ASSERT_EQ(s.bone.glenoid.rim_mm.size(), 6u);
    EXPECT_EQ(s.bone.glenoid.rim_mm[0], Vec3(13.5, 0, 0));
    EXPECT_EQ(s.bone.pilot_hole->depth_mm, 30);
    if (s.bone.source == BoneSource::ct && !s.bone.ct.label_map) {
      ASSERT_EQ(s.bone.ct.cut_spheres.size(), 2u);
      EXPECT_EQ(s.bone.ct.cut_spheres[0].radius_mm, 21.8);
      EXPECT_FALSE(s.bone.ct.fill_holes);
    }
    if (s.bone.ct.series == "2") {
      EXPECT_EQ(s.bone.ct.modality, Modality::any);
      EXPECT_EQ(s.bone.ct.uneven, Uneven::resample);
      EXPECT_EQ(s.bone.ct.label_map->label, (std::vector<std::string>{"7", "scapula: left", "8"}));
      EXPECT_EQ(s.bone.ct.label_map->refine_mm, 1);
    }
  }
}

TEST_F(RoundTrip, Passes) {
  const std::string yaml = kValid.substr(0, kValid.find("  keyframes:")) +
                           "  passes:\n  - tool: {mesh: tool.stl, scale: 0.5}\n    plunge: {depth_mm: 3}\n"
                           "  - plunge: {depth_mm: 5}\n" +
                           kValid.substr(kValid.find("render:"));
  const std::string written = resolved(yaml);
  EXPECT_THAT(written, HasSubstr("  passes:\n    - tool:\n        mesh: "));
  EXPECT_THAT(written, HasSubstr("    - plunge:\n        entry_mm: [0, 0, 0]\n"));
  const Scenario s = parse(written);
  ASSERT_EQ(s.motion.passes.size(), 2u);
  EXPECT_EQ(s.motion.passes[0].tool->scale, 0.5);
  EXPECT_EQ(s.motion.passes[0].plunge.depth_mm, 3);
  EXPECT_FALSE(s.motion.passes[1].tool.has_value());
  EXPECT_EQ(s.motion.passes[1].plunge.depth_mm, 5);
  EXPECT_EQ(resolved(written), written);
}

TEST_F(RoundTrip, NumbersAreExact) {
  std::mt19937_64 random(20261);
  std::uniform_real_distribution<double> uniform(0.01, 5);
  for (int i = 0; i < 50; ++i) {
    Scenario s = parse(kValid);
    s.bone.voxel_mm = uniform(random);
    s.motion.keyframes[0].position_mm = Vec3(uniform(random) * 1e-9, -uniform(random) * 1e3, uniform(random) / 3);
    const Scenario again = parse(to_yaml(s));
    EXPECT_EQ(again.bone.voxel_mm, s.bone.voxel_mm);
    EXPECT_EQ(again.motion.keyframes[0].position_mm, s.motion.keyframes[0].position_mm);
  }
}

TEST_F(RoundTrip, QuaternionsSettle) {
  std::mt19937_64 random(20262);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    Quat q(normal(random), normal(random), normal(random), normal(random));
    q.normalize();
    const std::string text = "quaternion: [" + number_text(q.w() * 1.001) + ", " + number_text(q.x()) + ", " +
                             number_text(q.y()) + ", " + number_text(q.z()) + "]}\n";
    const Scenario s = parse(with(kValid, "axis: [0, 0, 1]}\n", text));
    EXPECT_NEAR(s.motion.keyframes[0].quaternion->norm(), 1, 1e-15);
    const Scenario again = parse(to_yaml(s));
    EXPECT_EQ(again.motion.keyframes[0].quaternion->coeffs(), s.motion.keyframes[0].quaternion->coeffs());
  }
}

TEST_F(RoundTrip, OddTexts) {
  for (const std::string name :
       {"null", "true", "yes", "3", "a: b", "#x", " x ", "ä ö", "\"q\"", "\\", "-", "~", "on"}) {
    Scenario s = parse(kValid);
    s.name = name;
    EXPECT_EQ(parse(to_yaml(s)).name, name);
  }
  write("a ${b} $${c} 'd\".stl", "solid\n");
  Scenario s = parse(kValid);
  s.tool.mesh = path("a ${b} $${c} 'd\".stl");
  EXPECT_EQ(parse(to_yaml(s)).tool.mesh, s.tool.mesh);
}

TEST_F(RoundTrip, RecordedPoses) {
  write("poses.txt", "x");
  const std::vector<std::string> csv{"motion.keyframes=null", "motion.csv.path=poses.txt"};
  const auto with_csv = [&](std::vector<std::string> more) {
    more.insert(more.begin(), csv.begin(), csv.end());
    return more;
  };
  EXPECT_THAT(resolved(kValid, csv), HasSubstr("    separator: comma\n"));
  const std::string tum = resolved(kValid, with_csv({"motion.csv.format=tum"}));
  EXPECT_THAT(tum, HasSubstr("    separator: space\n"));
  EXPECT_THAT(
      tum, HasSubstr("    time_column: 1\n    time_unit: s\n    position_columns: [2, 3, 4]\n    position_unit: m\n"));
  EXPECT_THAT(tum, HasSubstr("    quaternion_columns: [5, 6, 7, 8]\n    quaternion_order: xyzw\n"));
  const Scenario s = parse(resolved(
      kValid,
      with_csv(
          {"motion.csv.position_columns=[Tx, \"T y\", 4]", "motion.csv.max_gap_s=0.1",
           "motion.csv.bone_from_tracker={translation_mm: [1, 2, 3], rotation: [[0, -1, 0], [1, 0, 0], [0, 0, 1]]}",
           "motion.csv.marker_from_tool.quaternion=[0.6, 0.8, 0, 0]"})));
  EXPECT_EQ(s.motion.csv->position_columns, (std::vector<std::string>{"Tx", "T y", "4"}));
  EXPECT_NEAR((s.motion.csv->bone_from_tracker->rigid() * Vec3(1, 0, 0) - Vec3(1, 3, 3)).norm(), 0, 1e-15);
  const auto said = [&](const std::string& more) { return complaint(kValid, with_csv({more})); };
  EXPECT_THAT(said("motion.csv.position_columns=[a, b]"), HasSubstr("found a list of 2; expected 3 names or numbers"));
  EXPECT_THAT(said("motion.csv.quaternion_columns=[0, 1, 2, 3]"), HasSubstr("found column 0; expected numbers from 1"));
  EXPECT_THAT(said("motion.csv.decimal=comma"), HasSubstr("which separates the columns"));
  EXPECT_THAT(said("motion.csv.bone_from_tracker.rotation=[[1, 0, 0], [0, 1, 0], [0, 0, -1]]"),
              HasSubstr("a reflection"));
  EXPECT_THAT(said("motion.csv.bone_from_tracker.rotation=[[1, 0, 0], [0, 1, 0], [0, 0.5, 1]]"),
              HasSubstr("not perpendicular"));
}

TEST_F(RoundTrip, InputFilesAreNamed) {
  write("scan.nrrd", "x");
  write("poses.csv", "x");
  const std::string phantom =
      "  source: phantom\n  voxel_mm: 0.5\n  phantom:\n    shape: half_space\n    size_mm: [10, 10, 6]\n";
  const std::string yaml = with(kValid, phantom, "  source: ct\n  ct: {path: scan.nrrd}\n");
  const Scenario s = parse(yaml, {"motion.keyframes=null", "motion.csv.path=poses.csv"});
  using Pair = std::pair<std::string, std::string>;
  EXPECT_THAT(input_files(s),
              ::testing::ElementsAre(Pair{"bone.ct.path", path("scan.nrrd")}, Pair{"tool.mesh", path("tool.stl")},
                                     Pair{"motion.csv.path", path("poses.csv")}));
}

}  // namespace
}  // namespace reamsim::test
