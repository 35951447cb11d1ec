// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Points from markups of 3D Slicer, as files of its versions have them.
#include "sim/scenario/markups.h"

#include <gmock/gmock.h>

#include <random>

#include "tests/scenario/scenario_fixture.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const std::string kColumns = "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n";

std::string fcsv(const std::string& version, const std::string& frame, const std::string& rows) {
  return "# Markups fiducial file version = " + version + "\n# CoordinateSystem = " + frame + "\n" + kColumns + rows;
}

const std::string kLpsRows =
    "1,22,-20,30,0,0,0,1,1,1,0,Glenoid center,,\n2,-2,-20,30.5,0,0,0,1,1,1,0,Trigonum spinae,,\n"
    "3,10,-20,18,0,0,0,1,1,1,0,Inferior angle,,\n";
const std::string kRasRows =
    "vtkMRMLMarkupsFiducialNode_0,-22.000,20.000,30.000,0.000,0.000,0.000,1.000,1,1,0,Glenoid center,,\n"
    "vtkMRMLMarkupsFiducialNode_1,2.000,20.000,30.500,0.000,0.000,0.000,1.000,1,1,0,Trigonum spinae,,\n"
    "vtkMRMLMarkupsFiducialNode_2,-10,20,18,0.000,0.000,0.000,1.000,1,1,0,Inferior angle,,vtkMRMLScalarVolumeNode1\n";

std::string json(const std::string& frame, const std::string& points, const std::string& unit = "\"mm\"") {
  return R"({"@schema": "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#",
 "markups": [{"type": "Fiducial", "coordinateSystem": ")" +
         frame + R"(", "coordinateUnits": )" + unit + R"(, "controlPoints": [)" + points + "]}]}\n";
}

std::string json_point(const std::string& label, const std::string& position) {
  return R"({"id": "1", "label": ")" + label + R"(", "position": )" + position + R"(, "positionStatus": "defined"})";
}

const std::string kLpsJson = json("LPS", json_point("Glenoid center", "[22, -20, 30]") + "," +
                                             json_point("Trigonum spinae", "[-2.0, -20.0, 30.5]") + "," +
                                             json_point("Inferior angle", "[1e1, -2e1, 18]"));

class MarkupsTest : public ScenarioTest {
 protected:
  Markups saved(const std::string& text, const std::string& name = "m.fcsv") const {
    write(name, text);
    return read_markups(path(name));
  }
  std::string error_of(const std::string& text) const {
    try {
      (void)saved(text);
    } catch (const InputError& error) {
      return without_dir(error.what());
    }
    return "no error";
  }
  /// kValid with landmarks.
  static std::string with_glenoid(const std::string& glenoid) {
    return with(kValid, "  voxel_mm: 0.5\n", "  side: left\n  voxel_mm: 0.5\n  glenoid:\n" + glenoid);
  }
};

TEST_F(MarkupsTest, EveryVersionGivesTheSamePoints) {
  const std::string list3 =
      "# Fiducial List file /home/x/L.fcsv\n# version = 2\n# name = L\n# numPoints = 3\n# symbolScale = 5\n"
      "# columns = label,x,y,z,sel,vis\nGlenoid center,-22,20,30,1,1\nTrigonum spinae,2,20,30.5,1,1\n"
      "Inferior angle,-10,20,18,1,1\n";
  for (const std::string& text : std::vector<std::string>{
           fcsv("4.11", "LPS", kLpsRows), fcsv("4.6", "1", kLpsRows), fcsv("4.10", "0", kRasRows),
           fcsv("5.2", "RAS", kRasRows), with(fcsv("4.4", "0", kRasRows), "# CoordinateSystem = 0\n", ""), list3,
           with(list3, "# columns = label,x,y,z,sel,vis\n", ""), list3.substr(list3.find("Glenoid")),
           // Slicer 5 adds the state of the point and its origin.
           fcsv("5.6", "LPS",
                "1,22,-20,30,0,0,0,1,1,1,0,Glenoid center,,,2,0\n2,-2,-20,30.5,0,0,0,1,1,1,0,Trigonum "
                "spinae,,,2,0\n3,10,-20,18,0,0,0,1,1,1,0,Inferior angle,,,2,0\n"),
           // Written with CRLF and a byte order mark; columns in another order.
           "\xef\xbb\xbf# Markups fiducial file version = 4.11\r\n# CoordinateSystem = LPS\r\n# columns = "
           "label,z,y,x\r\n"
           "Glenoid center,30,-20,22\r\nTrigonum spinae,30.5,-20,-2\r\n\r\nInferior angle,18,-20,10\r\n",
           kLpsJson, with(kLpsJson, "\"mm\"", "[\"mm\", \"UCUM\", \"millimeter\"]"),
           with(kLpsJson, "\"coordinateSystem\": \"LPS\", \"coordinateUnits\": \"mm\", ", ""),
           json("RAS", json_point("Glenoid center", "[-22, 20, 30]") + "," +
                           json_point("Trigonum spinae", "[2, 20, 30.5]") + "," +
                           json_point("Inferior angle", "[-10, 20, 18]"))}) {
    const Markups markups = saved(text);
    ASSERT_EQ(markups.points().size(), 3u) << text;
    EXPECT_EQ(markups.position_mm("Glenoid center"), Vec3(22, -20, 30)) << text;
    EXPECT_EQ(markups.position_mm("trigonum  SPINAE "), Vec3(-2, -20, 30.5)) << text;
    EXPECT_EQ(markups.positions_mm()[2], Vec3(10, -20, 18)) << text;
  }
}

TEST_F(MarkupsTest, OddFilesAreTheSamePoints) {
  const std::string folder = data_file("odd_files/");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder << "; set REAMSIM_DATA";
  for (const char* name : {"landmarks_lps.fcsv", "landmarks_ras.fcsv", "landmarks.mrk.json"}) {
    EXPECT_THAT(read_markups(folder + name).positions_mm(),
                ::testing::ElementsAre(Vec3(22, -20, 30), Vec3(-2, -20, 30), Vec3(10, -20, 18)))
        << name;
  }
}

TEST_F(MarkupsTest, JoinedFilesHaveOneFrame) {
  const std::string first = fcsv("4.11", "LPS", "1,1,2,3,0,0,0,1,1,1,0,a,,\n");
  EXPECT_EQ(saved(first + "#B\n" + fcsv("4.11", "LPS", "1,4,5,6,0,0,0,1,1,1,0,b,,\n")).position_mm("b"), Vec3(4, 5, 6));
  EXPECT_THAT(error_of(first + fcsv("4.11", "RAS", "1,4,5,6,0,0,0,1,1,1,0,b,,\n")),
              HasSubstr("m.fcsv:6: names its coordinate system after points; expected it before them"));
}

TEST_F(MarkupsTest, OtherUnitsBecomeMillimetres) {
  EXPECT_EQ(saved(json("LPS", json_point("a", "[0.022, -0.5, 0]"), "\"m\"")).only_position_mm(), Vec3(22, -500, 0));
  EXPECT_EQ(saved(json("LPS", json_point("a", "[2000, -1000, 0]"), "\"um\"")).only_position_mm(), Vec3(2, -1, 0));
  EXPECT_THAT(error_of(json("LPS", json_point("a", "[1, 2, 3]"), "\"furlong\"")),
              HasSubstr("m.fcsv: coordinateUnits is \"furlong\"; expected mm, um"));
}

TEST_F(MarkupsTest, LabelsMayHoldCommasAndQuotes) {
  const Markups markups = saved(fcsv("5.0", "LPS", "1,1,2,3,0,0,0,1,1,1,0,\"rim, \"\"upper\"\"\",\"a, b\",\n"));
  EXPECT_EQ(markups.position_mm("rim, \"upper\""), Vec3(1, 2, 3));
}

TEST_F(MarkupsTest, RefusesWithFileAndReason) {
  EXPECT_THAT(error_of(""), HasSubstr("m.fcsv: is empty; expected a markups file of 3D Slicer"));
  EXPECT_THAT(error_of("hello\n"), HasSubstr("m.fcsv:1: is no markups file of 3D Slicer"));
  EXPECT_THAT(error_of("point|1|2|3|1|1\n"), HasSubstr("annotation of an old 3D Slicer (.acsv)"));
  EXPECT_THAT(error_of(fcsv("4.10", "2", kRasRows)),
              HasSubstr("m.fcsv:2: CoordinateSystem is \"2\"; expected 0 or RAS"));
  EXPECT_THAT(error_of(fcsv("4.10", "IJK", kRasRows)), HasSubstr("CoordinateSystem is \"IJK\""));
  EXPECT_THAT(error_of(fcsv("4.10", "0", "a,1,2\n")), HasSubstr("m.fcsv:4: has no column z"));
  EXPECT_THAT(error_of(fcsv("4.10", "0", "a,1,zwei,3,0,0,0,1,1,1,0,F,,\n")), HasSubstr("m.fcsv:4: y is \"zwei\""));
  EXPECT_THAT(error_of(fcsv("4.10", "0", "a,1,nan,3,0,0,0,1,1,1,0,F,,\n")), HasSubstr("y is \"nan\""));
  EXPECT_THAT(error_of("{\"markups\": 3}"), HasSubstr("there is no list \"markups\""));
  EXPECT_THAT(error_of("{\"markups\": ["), HasSubstr("is no JSON, or is cut off"));
  EXPECT_THAT(error_of(json("SCANNER", json_point("a", "[1, 2, 3]"))), HasSubstr("coordinateSystem is \"SCANNER\""));
  EXPECT_THAT(error_of(json("LPS", json_point("a", "[1, 2]"))), HasSubstr("position of the point \"a\" is \"[1,2]\""));
  EXPECT_THAT(error_of(json("LPS", json_point("a", "[1, 2, \"3\"]"))), HasSubstr("expected 3 numbers"));
  EXPECT_THAT(error_of(json("LPS", "7")), HasSubstr("a control point that is no object"));
  EXPECT_THAT(error_of(std::string(100'000, '[')), HasSubstr("is no JSON"));
}

TEST_F(MarkupsTest, NoBytesEndTheProgram) {
  std::mt19937 random(45);
  for (const std::string& whole : {kLpsJson, fcsv("5.6", "LPS", kLpsRows)}) {
    for (int i = 0; i < 3000; ++i) {
      std::string text = whole.substr(0, random() % (whole.size() + 1));
      for (unsigned k = random() % 4; k > 0 && !text.empty(); --k)
        text[random() % text.size()] = static_cast<char>(random());
      const std::string said = error_of(text);
      for (const char c : said) ASSERT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= ' ') << said;
    }
  }
}

TEST_F(MarkupsTest, AnyKeyOfAPointTakesThem) {
  write("m.fcsv", fcsv("4.10", "0", kRasRows));
  std::filesystem::create_directory(path("sub"));
  write("sub/one.mrk.json", json("LPS", json_point("anything", "[1, 2, 3]")));
  const Scenario s = parse(with_glenoid("    near_mm: {markups: m.fcsv, point: Glenoid center}\n"
                                        "    landmarks:\n"
                                        "      glenoid_center_mm: {markups: m.fcsv, point: glenoid Center}\n"
                                        "      trigonum_spinae_mm: {markups: m.fcsv, point: Trigonum spinae}\n"
                                        "      inferior_angle_mm: {markups: ./m.fcsv, point: Inferior angle}\n"),
                           {"motion.keyframes.0.position_mm={markups: sub/one.mrk.json}"});
  EXPECT_EQ(*s.bone.glenoid.near_mm, Vec3(22, -20, 30));
  EXPECT_EQ(s.bone.glenoid.landmarks->inferior_angle_mm, Vec3(10, -20, 18));
  EXPECT_EQ(s.motion.keyframes[0].position_mm, Vec3(1, 2, 3));
  // The files are inputs of the run, each once; the resolved scenario has the numbers.
  using Pair = std::pair<std::string, std::string>;
  EXPECT_THAT(input_files(s),
              ::testing::ElementsAre(Pair{"tool.mesh", path("tool.stl")}, Pair{"bone.glenoid.near_mm", path("m.fcsv")},
                                     Pair{"motion.keyframes.0.position_mm", path("sub/one.mrk.json")}));
  const std::string resolved = to_yaml(s);
  EXPECT_THAT(resolved,
              AllOf(HasSubstr("near_mm: [22, -20, 30]\n"), HasSubstr("trigonum_spinae_mm: [-2, -20, 30.5]\n")));
  EXPECT_EQ(to_yaml(parse(resolved)), resolved);
  ASSERT_EQ(s.markups.size(), 5u);
  EXPECT_EQ(without_dir(s.markups[0].found), "\"Glenoid center\" of m.fcsv (RAS, as its header says)");
}

TEST_F(MarkupsTest, AListTakesAllPointsOrThoseThatAreNamed) {
  std::string rim, labels;
  const std::vector<Vec3> points{{13.5, 0, 0}, {9, 9, 1}, {0, 17, 0}, {-9, 9, 1}, {-13, 0, 0}, {0, -17, 0}};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3& p = points[i];
    rim += (i > 0 ? "," : "") +
           json_point("R-" + std::to_string(i + 1),
                      "[" + std::to_string(-p.x()) + "," + std::to_string(-p.y()) + "," + std::to_string(p.z()) + "]");
    labels += (i > 0 ? ", R-" : "R-") + std::to_string(i + 1);
  }
  write("rim.mrk.json", with(json("RAS", rim), "Fiducial", "ClosedCurve"));
  const std::string frame = "    center_mm: [0, 0, 0]\n    normal: [0, 0, 1]\n    superior: [0, 1, 0]\n    rim_mm: ";
  const std::string typed = "[[13.5, 0, 0], [9, 9, 1], [0, 17, 0], [-9, 9, 1], [-13, 0, 0], [0, -17, 0]]\n";
  const std::string expected = to_yaml(parse(with_glenoid(frame + typed)));
  EXPECT_EQ(to_yaml(parse(with_glenoid(frame + "{markups: rim.mrk.json}\n"))), expected);
  EXPECT_EQ(to_yaml(parse(with_glenoid(frame + "{markups: rim.mrk.json, point: [" + labels + "]}\n"))), expected);
  EXPECT_EQ(to_yaml(parse(with_glenoid(frame + with(typed, "[13.5, 0, 0]", "{markups: rim.mrk.json, point: R-1}")))),
            expected);
  EXPECT_THAT(complaint(with_glenoid(frame + "{markups: rim.mrk.json, point: R-1}\n")),
              HasSubstr("bone.glenoid.rim_mm: found 1 points in rim.mrk.json; expected at least 6"));
}

TEST_F(MarkupsTest, MistakesNameKeyFileAndLabels) {
  write("m.fcsv", fcsv("4.10", "0", kRasRows));
  const auto say = [&](const std::string& value) { return complaint(with_glenoid("    near_mm: " + value + "\n")); };
  EXPECT_THAT(
      say("{markups: m.fcsv, point: Glenoid centre}"),
      HasSubstr("s.yaml:7:14: bone.glenoid.near_mm: m.fcsv: has no point \"Glenoid centre\"; expected one of the "
                "labels \"Glenoid center\", \"Trigonum spinae\", \"Inferior angle\""));
  EXPECT_THAT(say("{markups: m.fcsv}"), HasSubstr("m.fcsv: has 3 points; name one: point: LABEL, one of \"Glenoid"));
  EXPECT_THAT(say("{markups: absent.fcsv, point: a}"), HasSubstr("bone.glenoid.near_mm: no such file: absent.fcsv"));
  EXPECT_THAT(say("{markups: m.fcsv, label: a}"), HasSubstr("found label; expected {markups: FILE, point: LABEL}"));
  EXPECT_THAT(say("{point: a}"),
              HasSubstr("expected 3 numbers [x, y, z], each -10000 to 10000 (mm), or {markups: FILE"));
  EXPECT_THAT(say("{markups: [1], point: a}"), HasSubstr("markups is a list of 1"));
  EXPECT_THAT(say("{markups: m.fcsv, point: [a, b]}"), HasSubstr("point has 2 labels; expected one"));
  write("m.fcsv", fcsv("5.6", "LPS",
                       "1,0,0,0,0,0,0,1,1,1,0,Glenoid center,,,0,0\n2,1,1,1,0,0,0,1,1,1,0,a,,,2,0\n"
                       "3,1,1,1,0,0,0,1,1,1,0,a,,,2,0\n4,1e6,1,1,0,0,0,1,1,1,0,far,,,2,0\n"));
  EXPECT_THAT(say("{markups: m.fcsv, point: Glenoid center}"), HasSubstr("is not placed yet"));
  EXPECT_THAT(say("{markups: m.fcsv, point: a}"), HasSubstr("has 2 points with the label \"a\""));
  EXPECT_THAT(say("{markups: m.fcsv, point: far}"), HasSubstr("found the point (1000000, 1, 1) mm"));
  write("m.fcsv", "");
  EXPECT_THAT(say("{markups: m.fcsv, point: far}"), HasSubstr("bone.glenoid.near_mm: m.fcsv: is empty"));
  // A direction is no point.
  EXPECT_THAT(complaint(with(kValid, "axis: [0, 0, 1]", "axis: {markups: m.fcsv, point: a}")),
              HasSubstr("motion.keyframes.0.axis: found a section of keys; expected 3 numbers"));
}

TEST_F(MarkupsTest, TheyAreInTheFrameOfTheBone) {
  write("m.fcsv", fcsv("4.11", "LPS", kLpsRows));
  const std::string value = "{markups: m.fcsv, point: Glenoid center}";
  const std::string plunge = "  plunge: {entry_mm: " + value + "}\n";
  std::string yaml = kValid.substr(0, kValid.find("  keyframes:")) + plunge + kValid.substr(kValid.find("render:"));
  EXPECT_EQ(parse(yaml).motion.plunge->entry_mm, Vec3(22, -20, 30));
  yaml = with(yaml, "  voxel_mm", "  side: left\n  voxel_mm");
  EXPECT_THAT(complaint(yaml, {"motion.frame=glenoid"}),
              HasSubstr("motion.plunge.entry_mm: found a point of markups, which is in the frame of the bone, and "
                        "motion.frame is glenoid; expected frame: bone, or 3 numbers"));
  EXPECT_THAT(complaint(yaml, {"bone.pilot_hole.entry_mm=" + value, "bone.pilot_hole.frame=glenoid"}),
              HasSubstr("bone.pilot_hole.frame is glenoid"));
  EXPECT_THAT(complaint(yaml, {"metrics.implant.backside_radius_mm=0", "metrics.implant.center_mm=" + value}),
              HasSubstr("metrics.implant.frame is reamer"));
  EXPECT_EQ(complaint(yaml, {"metrics.implant.backside_radius_mm=0", "metrics.implant.center_mm=" + value,
                             "metrics.implant.frame=bone"}),
            "");
}

}  // namespace
}  // namespace reamsim::test
