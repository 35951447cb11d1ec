// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// 3D Slicer: landmarks in, planning out, and all results over the scan.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "tests/cli/cli_fixture.h"
#include "tests/cli/data_files.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using SlicerJson = nlohmann::json;
using Point = std::array<double, 3>;

std::string fcsv(const std::string& frame, const std::vector<std::pair<std::string, Point>>& points) {
  std::string out = "# Markups fiducial file version = 5.6\n# CoordinateSystem = " + frame +
                    "\n# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n";
  const double sign = frame == "LPS" || frame == "1" ? 1 : -1;
  for (const auto& [label, p] : points) {
    out += "1," + std::to_string(sign * p[0]) + "," + std::to_string(sign * p[1]) + "," + std::to_string(p[2]) +
           ",0,0,0,1,1,1,0," + label + ",,,2,0\n";
  }
  return out;
}

std::string mrk_json(const std::vector<std::pair<std::string, Point>>& points) {
  SlicerJson list = SlicerJson::array();
  for (const auto& [label, p] : points)
    list.push_back({{"label", label}, {"position", p}, {"positionStatus", "defined"}});
  const SlicerJson markup{{"type", "Fiducial"}, {"coordinateSystem", "LPS"}, {"controlPoints", list}};
  return SlicerJson{{"@schema", "markups-schema-v1.0.3.json#"}, {"markups", SlicerJson::array({markup})}}.dump();
}

/// block_nrrd() in RAS, moved: the block is x -24.5…-14.5, y -34.5…-24.5, z 34.5…44.5 in LPS.
std::string moved_nrrd() {
  std::string nrrd = block_nrrd();
  const std::size_t data = nrrd.find("\n\n");
  return "NRRD0004\ntype: int16\ndimension: 3\nspace: right-anterior-superior\nsizes: 20 20 20\n"
         "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (10,20,30)\nendian: little\nencoding: raw" +
         nrrd.substr(data);
}

class SlicerTest : public CliTest {
 protected:
  ProgramResult call(const std::vector<std::string>& arguments) const {
    return reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
  }
  SlicerJson json(const std::string& name) const { return SlicerJson::parse(read(name)); }
  /// Lines of a resolved scenario that are no comments: its values.
  std::string values_of(const std::string& name) const {
    std::string out;
    std::istringstream lines(read(name));
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with('#') && !line.starts_with("name:")) out += line + "\n";
    }
    return out;
  }
  /// The markup of this name in planning.mrk.json, which is in LPS and mm.
  SlicerJson markup(const SlicerJson& planning, const std::string& name) const {
    for (const SlicerJson& one : planning["markups"]) {
      EXPECT_EQ(one["coordinateSystem"], "LPS");
      EXPECT_EQ(one["coordinateUnits"], "mm");
      if (one["name"] == name) return one;
    }
    ADD_FAILURE() << "no markup " << name << " in " << planning.dump(1);
    return {};
  }
};

const Point kTop{-19.5, -29.5, 44.5};

TEST_F(SlicerTest, ARunWithMarkupsIsTheRunWithTheNumbers) {
  meshes_ = true;
  write("scan.nrrd", moved_nrrd());
  const std::string bone = "  source: ct\n  voxel_mm: 0.5\n  ct: {path: scan.nrrd, closing_mm: 0}\n";
  const auto scenario = [&](const std::string& entry) {
    return with(with_bone(bone), "  plunge:\n", "  plunge:\n    entry_mm: " + entry + "\n");
  };
  expect_done(run(scenario("[-19.5, -29.5, 44.5]")));
  std::filesystem::rename(path("out"), path("typed"));
  std::filesystem::create_directory(path("marks"));
  const std::vector<std::pair<std::string, Point>> points{{"other", {1, 2, 3}}, {"Top", kTop}};
  for (const std::string& text : {fcsv("LPS", points), fcsv("0", points), mrk_json(points)}) {
    write("marks/m.markups", text);  // the content says what it is
    expect_done(run(scenario("{markups: marks/m.markups, point: Top}"), {"--overwrite"}));
    for (const char* file : {"forces.csv", "reamed.vti", "reamed.stl", "planning.mrk.json", "depth_map.csv"})
      EXPECT_TRUE(read(std::string("out/") + file) == read(std::string("typed/") + file)) << file << "\n" << text;
    EXPECT_EQ(values_of("out/scenario.yaml"), values_of("typed/scenario.yaml"));
  }
  // The file is an input of the run.
  const SlicerJson inputs = json("out/summary.json")["inputs"];
  EXPECT_EQ(inputs.back()["role"], "motion.plunge.entry_mm");
  EXPECT_THAT(inputs.back()["path"].get<std::string>(), HasSubstr("marks/m.markups"));
  EXPECT_THAT(read("out/scenario.yaml"), HasSubstr(inputs.back()["sha256"].get<std::string>()));
  const ProgramResult checked = call({"check", "s.yaml"});
  EXPECT_THAT(checked.out, HasSubstr("motion.plunge.entry_mm: \"Top\" of "));
  const ProgramResult wrong =
      call({"check", "s.yaml", "--set", "motion.plunge.entry_mm={markups: marks/m.markups, point: Tip}"});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_THAT(wrong.err, AllOf(HasSubstr("has no point \"Tip\""), HasSubstr("\"other\", \"Top\"")));
}

TEST_F(SlicerTest, ResultsLieOverTheScan) {
  meshes_ = true;
  write("scan.nrrd", moved_nrrd());
  write("m.fcsv", fcsv("RAS", {{"Top", kTop}}));
  expect_done(run(with(with_bone("  source: ct\n  voxel_mm: 0.5\n  ct: {path: scan.nrrd, closing_mm: 0}\n"),
                       "  plunge:\n", "  plunge:\n    entry_mm: {markups: m.fcsv}\n")));
  const Point least{-24.5, -34.5, 34.5}, most{-14.5, -24.5, 44};  // reamed 1 mm deep, but for a core
  const std::string stl = read("out/reamed.stl");
  EXPECT_THAT(stl.substr(0, 80), HasSubstr("SPACE=LPS"));
  Point low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
  for (std::size_t facet = 84; facet + 50 <= stl.size(); facet += 50) {
    for (std::size_t i = 0; i < 9; ++i) {
      float x = 0;
      std::memcpy(&x, stl.data() + facet + 12 + 4 * i, 4);
      low[i % 3] = std::min(low[i % 3], double{x});
      high[i % 3] = std::max(high[i % 3], double{x});
    }
  }
  const std::string vti = read("out/reamed.vti");
  Point origin{}, spacing{};
  std::array<int, 3> last{};
  ASSERT_EQ(
      std::sscanf(vti.c_str() + vti.find("WholeExtent="),
                  "WholeExtent=\"0 %d 0 %d 0 %d\" Origin=\"%lf %lf %lf\" Spacing=\"%lf %lf %lf\"", last.data(),
                  &last[1], &last[2], origin.data(), &origin[1], &origin[2], spacing.data(), &spacing[1], &spacing[2]),
      9);
  EXPECT_THAT(vti.substr(0, 1000), Not(HasSubstr("Direction"))) << "the axes are those of LPS";
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(low[i], least[i], 0.7) << i;
    EXPECT_NEAR(high[i], most[i], 0.7) << i;
    EXPECT_LE(origin[i], least[i] + 0.5);
    EXPECT_GT(origin[i], least[i] - 10);
    EXPECT_GE(origin[i] + last[i] * spacing[i], most[i] - 0.5);
  }
  const SlicerJson planning = json("out/planning.mrk.json");
  EXPECT_THAT(planning["@schema"].get<std::string>(), HasSubstr("markups-schema-v1.0.3.json"));
  const SlicerJson points = markup(planning, "reaming")["controlPoints"];
  EXPECT_EQ(points.front()["label"], "entry");
  EXPECT_EQ(points.front()["position"], SlicerJson(kTop));
  EXPECT_NEAR(points.back()["position"][2].get<double>(), kTop[2] - 1, 1e-9);
  // And reamsim reads it.
  const ProgramResult checked =
      call({"check", "s.yaml", "--set", "motion.plunge.entry_mm={markups: out/planning.mrk.json, point: entry}"});
  EXPECT_EQ(checked.status, 0) << checked.err;
  EXPECT_THAT(checked.out, HasSubstr("entry_mm: [-19.5, -29.5, 44.5]"));
}

TEST_F(SlicerTest, ASegmentationOfTheReamedBoneLiesOverTheScan) {
  write("scan.nrrd", moved_nrrd());
  const std::string scenario =
      with(with_bone("  source: ct\n  voxel_mm: 0.25\n  ct: {path: scan.nrrd, closing_mm: 0}\n"), "  plunge:\n",
           "  plunge:\n    entry_mm: [-19.5, -29.5, 44.5]\n");
  expect_done(run(with(scenario, "render:\n", "output:\n  segmentation: true\nrender:\n")));
  const std::string nrrd = read("out/reamed.seg.nrrd");
  const std::string header = nrrd.substr(0, nrrd.find("\n\n"));
  EXPECT_THAT(header, AllOf(HasSubstr("\nspace: left-posterior-superior\n"), HasSubstr("\nencoding: gzip\n"),
                            HasSubstr("\nspace directions: (0.25,0,0) (0,0.25,0) (0,0,0.25)\n"),
                            HasSubstr("\nSegment0_Name:=remaining bone\nSegment0_LabelValue:=1\n"),
                            HasSubstr("\nSegment1_Name:=removed bone\nSegment1_LabelValue:=2\n")));
  std::array<int, 3> size{};
  Point origin{};
  ASSERT_EQ(std::sscanf(header.c_str() + header.find("sizes:"), "sizes: %d %d %d", size.data(), &size[1], &size[2]), 3);
  const std::string extent = "Extent:=0 " + std::to_string(size[0] - 1) + " 0 " + std::to_string(size[1] - 1) + " 0 " +
                             std::to_string(size[2] - 1) + "\n";
  EXPECT_THAT(header + "\n", AllOf(HasSubstr("\nSegment0_" + extent), HasSubstr("\nSegment1_" + extent)));
  ASSERT_EQ(std::sscanf(header.c_str() + header.find("space origin:"), "space origin: (%lf,%lf,%lf)", origin.data(),
                        &origin[1], &origin[2]),
            3);
  write("labels.gz", nrrd.substr(header.size() + 2));
  std::string labels(std::size_t{1} * size[0] * size[1] * size[2] + 1, '?');
  const gzFile in = gzopen(path("labels.gz").c_str(), "rb");
  const int got = gzread(in, labels.data(), static_cast<unsigned>(labels.size()));
  gzclose(in);
  ASSERT_EQ(static_cast<std::size_t>(got) + 1, labels.size());
  labels.pop_back();
  std::array<double, 3> count{};
  Point low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
  for (std::size_t n = 0; n < labels.size(); ++n) {
    ASSERT_LE(labels[n], 2);
    ++count[static_cast<std::size_t>(labels[n])];
    if (labels[n] == 0) continue;
    const auto nx = static_cast<std::size_t>(size[0]), ny = static_cast<std::size_t>(size[1]);
    const std::array<std::size_t, 3> at{n % nx, n / nx % ny, n / nx / ny};
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], origin[i] + 0.25 * static_cast<double>(at[i]));
      high[i] = std::max(high[i], origin[i] + 0.25 * static_cast<double>(at[i]));
    }
  }
  const Point least{-24.5, -34.5, 34.5}, most{-14.5, -24.5, 44.5};  // faces of the block
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(low[i], least[i], 0.5) << i;
    EXPECT_NEAR(high[i], most[i], 0.5) << i;
  }
  const SlicerJson bone = json("out/summary.json")["bone"];
  const double voxel_mm3 = 0.25 * 0.25 * 0.25;
  EXPECT_NEAR(count[1] * voxel_mm3 / bone["bone_after_mm3"].get<double>(), 1, 0.05);
  EXPECT_NEAR(count[2] * voxel_mm3 / bone["removed_mm3"].get<double>(), 1, 0.25);  // half a voxel of a cut of 1 mm
  const ProgramResult phantom = call({"check", "s.yaml", "--set", "bone.source=phantom"});
  EXPECT_EQ(phantom.status, 2);
  EXPECT_THAT(phantom.err, HasSubstr("output.segmentation: found true; expected false"));
}

TEST_F(SlicerTest, PlanningHasPlanesAxisPegsAndLandmarks) {
  const std::string bone = "  source: phantom\n  side: left\n  voxel_mm: 0.8\n  phantom: {shape: glenoid}\n";
  expect_done(run(with(with_bone(bone), "motion:\n",
                       "metrics:\n  implant:\n    backside_radius_mm: 0\n    diameter_mm: 20\n"
                       "    pegs:\n      - {from_mm: [0, 0, 0], to_mm: [0, 0, -10], "
                       "diameter_mm: 4}\nmotion:\n  frame: glenoid\n")));
  const SlicerJson planning = json("out/planning.mrk.json");
  const SlicerJson native = markup(planning, "native face"), reamed = markup(planning, "reamed face");
  for (const SlicerJson& plane : {native, reamed}) {
    EXPECT_EQ(plane["type"], "Plane");
    EXPECT_EQ(plane["planeType"], "pointNormal");
    const SlicerJson &normal = plane["normal"], &matrix = plane["baseToNode"];
    double length = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      length += normal[i].get<double>() * normal[i].get<double>();
      EXPECT_NEAR(matrix[4 * i + 2].get<double>(), normal[i].get<double>(), 1e-9) << "z of the frame is the normal";
      EXPECT_NEAR(matrix[4 * i + 3].get<double>(), plane["center"][i].get<double>(), 1e-9);
      EXPECT_EQ(plane["center"][i], plane["controlPoints"][0]["position"][i]);
    }
    EXPECT_NEAR(length, 1, 1e-9);
    EXPECT_GT(normal[0].get<double>(), 0.9) << "lateral, out of the bone";
  }
  const SlicerJson axis = markup(planning, "reamer axis")["controlPoints"];
  EXPECT_NEAR(axis[1]["position"][0].get<double>() - axis[0]["position"][0].get<double>(), 60, 1e-6);
  const SlicerJson peg = markup(planning, "peg 1")["controlPoints"];
  EXPECT_NEAR(peg[0]["position"][0].get<double>() - peg[1]["position"][0].get<double>(), 10, 1e-6);
  EXPECT_EQ(markup(planning, "landmarks")["controlPoints"].size(), 3u);
  EXPECT_EQ(markup(planning, "glenoid rim")["type"], "ClosedCurve");
}

class InitMarkupsTest : public SlicerTest {
 protected:
  /// The surface of the glenoid phantom, whose face is about the origin.
  void write_glenoid_mesh() {
    meshes_ = true;
    write("phantom.yaml", with(with(with_bone("  source: phantom\n  side: left\n  voxel_mm: 1.2\n  phantom:\n"
                                              "    shape: glenoid\n"),
                                    "  plunge:\n", "  plunge:\n    entry_mm: [200, 0, 0]\n"),
                               "render:\n", "output:\n  vti: false\nrender:\n"));
    ASSERT_EQ(call({"run", "phantom.yaml", "-o", "phantom"}).status, 0);
    meshes_ = false;
    std::filesystem::copy_file(path("phantom/reamed.stl"), path("bone.stl"));
  }
  ProgramResult init(const std::vector<std::string>& more) const {
    std::vector<std::string> arguments{"init", "bone.stl",   "-o",  "my.yaml",    "--side",
                                       "left", "--voxel-mm", "1.2", "--overwrite"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return call(arguments);
  }
};

TEST_F(InitMarkupsTest, TakesLandmarksByTheirLabels) {
  write_glenoid_mesh();
  const std::vector<std::pair<std::string, Point>> points{{"Glenoid centre", {3, -2, 4}},
                                                          {"TS", {0.5, 12.25, -105}},
                                                          {"inferior_angle-1", {6, -105.5, -80}},
                                                          {"coracoid", {9, 9, 9}}};
  std::string first;
  for (const std::string& text : {fcsv("LPS", points), fcsv("RAS", points), mrk_json(points)}) {
    write("m", text);
    const ProgramResult made = init({"--markups", "m"});
    ASSERT_EQ(made.status, 0) << made.err;
    EXPECT_THAT(made.out, AllOf(HasSubstr("markups: center: \"Glenoid centre\" of m ("),
                                HasSubstr("markups: trigonum: \"TS\" of m ("),
                                HasSubstr("markups: inferior_angle: \"inferior_angle-1\" of m ("),
                                HasSubstr("markups: not used: the points \"coracoid\"; --point ROLE=LABEL")));
    if (first.empty()) first = read("my.yaml");
    EXPECT_EQ(read("my.yaml"), first);
  }
  EXPECT_THAT(first, AllOf(HasSubstr("near_mm: [3.00, -2.00, 4.00]"), HasSubstr("    landmarks:"),
                           HasSubstr("      trigonum_spinae_mm: [0.5, 12.25, -105]\n"),
                           HasSubstr("      inferior_angle_mm: [6, -105.5, -80]\n"), Not(HasSubstr("superior: ["))));
  const ProgramResult done = call({"run", "my.yaml", "-o", "out", "--set", "render.enabled=false", "--device", "serial",
                                   "--set", "motion.frame_rate_hz=100"});
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_GT(number_after(read("out/summary.json"), "\"removed_mm3\": "), 300);
}

TEST_F(InitMarkupsTest, SuperiorRimAndNamedPoints) {
  write_glenoid_mesh();
  std::vector<std::pair<std::string, Point>> points{
      {"GC", {3, -2, 4}}, {"glenoid_superior", {3, 14, 4}}, {"P7", {0, 0, 0}}};
  // Not in order round the face.
  const std::array<Point, 6> rim{{{4.7, 17, 0}, {2.3, 0, -12}, {4.7, -17, 0}, {2.3, 0, 12}, {2.6, 9, -9}, {2.6, 9, 9}}};
  for (std::size_t i = 0; i < rim.size(); ++i) points.push_back({"Rim-" + std::to_string(i + 1), rim[i]});
  for (const std::size_t i : {0u, 2u, 3u}) points.push_back({"Face-" + std::to_string(i), rim.at(i)});
  points.push_back({"Anterior glenoid margin", {2.3, 0, 12.5}});
  points.push_back({"VaultTip", {0, 0, -30}});
  write("m.mrk.json", mrk_json(points));
  const ProgramResult made = init({"--markups", "m.mrk.json"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_THAT(made.out, HasSubstr("markups: rim: 6 points"));
  EXPECT_THAT(read("my.yaml"), AllOf(HasSubstr("superior: [0, 1, 0]"), HasSubstr("    rim_mm:"),
                                     HasSubstr("    version_landmarks:\n      face_mm:\n        - [4.7, 17, 0]\n"),
                                     HasSubstr("      anterior_margin_mm: [2.3, 0, 12.5]\n      vault_tip_mm: ")));
  const ProgramResult named = init({"--markups", "m.mrk.json", "--point", "center=P7"});
  ASSERT_EQ(named.status, 0) << named.err;
  EXPECT_THAT(read("my.yaml"), HasSubstr("near_mm: [0.00, 0.00, 0.00]"));

  const auto refused = [&](const std::vector<std::string>& more) {
    const ProgramResult result = init(more);
    EXPECT_EQ(result.status, 2) << result.out;
    return result.err;
  };
  EXPECT_THAT(refused({"--markups", "m.mrk.json", "--point", "middle=P7"}), HasSubstr("--point: found \"middle=P7\""));
  EXPECT_THAT(refused({"--markups", "m.mrk.json", "--point", "center=P8"}),
              AllOf(HasSubstr("no point \"P8\""), HasSubstr("\"GC\", \"glenoid_superior\"")));
  EXPECT_THAT(refused({"--markups", "m.mrk.json", "--near=1,2,3"}), HasSubstr("--near: given beside the centre"));
  EXPECT_THAT(refused({"--point", "center=P7"}), HasSubstr("--markups"));
  write("m.mrk.json", mrk_json({{"GC", {3, -2, 4}}, {"Glenoid", {3, -2, 4}}}));
  EXPECT_THAT(refused({"--markups", "m.mrk.json"}), HasSubstr("several points may be the center"));
  write("m.mrk.json", mrk_json({{"F-1", {3, -2, 4}}}));
  EXPECT_THAT(refused({"--markups", "m.mrk.json"}),
              AllOf(HasSubstr("no label was understood"), HasSubstr("\"F-1\""), HasSubstr("--point ROLE=LABEL")));
}

}  // namespace
}  // namespace reamsim::test
