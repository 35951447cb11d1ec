// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Mistakes of a pose and a side: said by `check` and by `run`, with the number, before anything is simulated.
#include <cmath>
#include <cstring>

#include "tests/cli/cli_fixture.h"
#include "tests/cli/data_files.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// A mesh's cube, 40 mm wide, whose upper face z = 40 is reamed; `glenoid` are the keys of bone.glenoid.
std::string cube_scenario(const std::string& glenoid, const std::string& frame = "glenoid") {
  return "version: 2\n"                // 1
         "bone:\n"                     // 2
         "  source: mesh\n"            // 3
         "  side: left\n"              // 4
         "  voxel_mm: 0.8\n"           // 5
         "  mesh: {path: cube.stl}\n"  // 6
         "  glenoid: {" +
         glenoid +
         "}\n"  // 7
         "tool:\n  mesh: " REAMSIM_ROOT
         "/assets/reamer_convex.stl\n"  // 8
         "motion:\n"                    // 10
         "  frame: " +
         frame +
         "\n"                     // 11
         "  frame_rate_hz: 50\n"  // 12
         "  plunge: {approach_mm: 2, feed_mm_s: 4, depth_mm: 1, dwell_s: 0, retract_mm: 2, retract_mm_s: 20}\n"
         "render:\n  enabled: false\noutput:\n  meshes: false\nengine:\n  device: serial\n";
}

const std::string kRight = "center_mm: [20, 20, 40], normal: [0, 0, 1], superior: [0, 1, 0]";

class PoseMistakes : public CliTest {
 protected:
  PoseMistakes() { write("cube.stl", cube_stl(40)); }

  ProgramResult check(const std::string& yaml, const std::vector<std::string>& more = {}) const {
    write("s.yaml", yaml);
    ProgramCall call{.arguments = {"check", "s.yaml"}, .environment = {}, .folder = "", .interrupt_when = {}};
    call.arguments.insert(call.arguments.end(), more.begin(), more.end());
    return reamsim(call);
  }
  /// Both commands refuse it for the same reason, in one line.
  void expect_both_refuse(const std::string& yaml, std::initializer_list<const char*> words) const {
    expect_refused(check(yaml), 2, words);
    expect_refused(run(yaml), 2, words);
  }
};

TEST_F(PoseMistakes, AFrameOnTheBoneIsFine) {
  const ProgramResult result = check(cube_scenario(kRight));
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.err, "");
}

TEST_F(PoseMistakes, InwardNormal) {
  const std::string yaml = cube_scenario("center_mm: [20, 20, 40], normal: [0, 0, -1], superior: [0, 1, 0]");
  expect_both_refuse(
      yaml, {"s.yaml:7:", "bone.glenoid.normal", "points into the bone", "mm3", "give the direction out of the bone"});
  EXPECT_THAT(check(yaml).out, HasSubstr("# memory: ")) << "the cost is said all the same";
}

TEST_F(PoseMistakes, CenterFarFromTheBone) {
  const auto centre = [](const char* at) {
    return cube_scenario("center_mm: " + std::string(at) + ", normal: [0, 0, 1], superior: [0, 1, 0]");
  };
  expect_both_refuse(centre("[20, 20, 60]"), {"s.yaml:7:", "bone.glenoid.center_mm: found (20.0, 20.0, 60.0), 20.",
                                              "outside the surface of the bone", "within 10 mm", "39."});
  expect_both_refuse(centre("[20, 20, 20]"), {"bone.glenoid.center_mm", "inside the surface of the bone"});
  for (const char* near : {"[20, 20, 48]", "[20, 20, 32]"})
    EXPECT_EQ(check(centre(near)).err.find("error"), std::string::npos);
}

TEST_F(PoseMistakes, BothAtOnceAndTheToolAsWell) {
  std::string yaml = cube_scenario("center_mm: [20, 20, 40], normal: [0, 0, -1], superior: [0, 1, 0]");
  write("open.stl", cube_stl(10, 1));
  const ProgramResult result = check(with(yaml, REAMSIM_ROOT "/assets/reamer_convex.stl", "open.stl"));
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.err, AllOf(HasSubstr("open.stl"), HasSubstr("points into the bone")));
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 2) << result.err;
}

TEST_F(PoseMistakes, NormalAskew) {
  const ProgramResult result =
      check(cube_scenario("center_mm: [20, 20, 40], normal: [1, 0, 0.2], superior: [0, 1, 0]"));
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.err,
              AllOf(HasSubstr("warning: the glenoid's normal is about 7"), HasSubstr("bone.glenoid.normal")));
}

TEST_F(PoseMistakes, ToolBesideTheBone) {
  // The rim of the reamer, of 15 mm radius, passes 5 mm beside and at last 3.2 mm above the edge of the cube.
  const std::string beside = with(cube_scenario(kRight, "bone"), "plunge: {", "plunge: {entry_mm: [60, 20, 40], ");
  const ProgramResult checked = check(beside);
  EXPECT_EQ(checked.status, 0);
  EXPECT_THAT(checked.err, HasSubstr("the tool never touches the bone: its smallest distance is"));
  EXPECT_NEAR(number_after(checked.err, "smallest distance is "), std::hypot(5, 3.2), 0.8) << checked.err;
  const ProgramResult done = run(beside);
  expect_done(done);
  EXPECT_THAT(done.err, AllOf(HasSubstr("never touches the bone"), Not(HasSubstr("never touches the bone;"))));
}

TEST_F(PoseMistakes, ToolThatStartsInTheBone) {
  // 12 mm deep at its first pose.
  const std::string deep = with(cube_scenario(kRight), "plunge: {", "plunge: {entry_mm: [0, 0, -14], ");
  const ProgramResult checked = check(deep);
  EXPECT_EQ(checked.status, 0);
  EXPECT_THAT(checked.err, HasSubstr("the tool starts in the bone: at its first pose it contains about "));
  const double foretold_mm3 =
      number_after(checked.err, "the tool starts in the bone: at its first pose it contains about ");
  const ProgramResult done = run(deep);
  expect_done(done);
  const std::size_t foretold = done.err.find("the tool starts in the bone: at its first pose it contains about ");
  const std::size_t measured = done.err.find("the tool starts in the bone: ", foretold + 10);
  ASSERT_NE(foretold, std::string::npos) << done.err;
  ASSERT_NE(measured, std::string::npos) << done.err;
  const double removed_mm3 = number_after(done.err.substr(measured), "the tool starts in the bone: ");
  EXPECT_NEAR(foretold_mm3 / removed_mm3, 1, 0.02);
}

#ifndef __SANITIZE_ADDRESS__  // whose own memory would be measured
TEST_F(PoseMistakes, MemoryStaysPlannedWhateverThePose) {
  // Whatever the tool does: deep in the bone from the start, through the whole bone, past it.
  const std::string yaml = with(cube_scenario(kRight), "engine:\n  device: serial\n", "");
  for (const char* entry : {"[0, 0, -14]", "[0, 0, -30]", "[0, 0, 30]"}) {
    const std::vector<std::string> sets{"--set",      std::string("motion.plunge.entry_mm=") + entry,
                                        "--set",      "motion.plunge.depth_mm=20",
                                        "--set",      "bone.voxel_mm=0.25",
                                        "--set",      "motion.frame_rate_hz=10",
                                        "--overwrite"};
    expect_done(run(yaml, sets));
    const ProgramResult checked = check(yaml, {sets.begin(), sets.end() - 1});
    const double foretold_mb = number_after(checked.out, "on the device, up to ");
    const double taken_mb = number_after(read("out/summary.json"), "\"peak_process\": ");
    RecordProperty(std::string("foretold_mb ") + entry, std::to_string(foretold_mb));
    RecordProperty(std::string("taken_mb ") + entry, std::to_string(taken_mb));
    EXPECT_LT(taken_mb, foretold_mb) << entry;
    EXPECT_GT(taken_mb, foretold_mb / 2) << entry;
  }
}
#endif

/// The scan of data_files.h; its block is bone from 5 to 15 mm. `side` and frame on the block's +x face.
std::string scan_scenario(const std::string& side, const std::string& normal, const std::string& superior) {
  return "version: 2\nbone:\n  source: ct\n  side: " + side + "\n  voxel_mm: 1\n  ct: {path: scan.nrrd}\n  glenoid: {" +
         "center_mm: [14.5, 10, 10], normal: " + normal + ", superior: " + superior +
         "}\ntool:\n  mesh: " REAMSIM_ROOT
         "/assets/reamer_flat.stl\nmotion:\n  frame: glenoid\n  frame_rate_hz: 50\n  plunge: {approach_mm: 2, "
         "feed_mm_s: 4, depth_mm: 1, dwell_s: 0, retract_mm: 2, retract_mm_s: 20}\nrender:\n  enabled: false\n"
         "engine:\n  device: serial\n";
}

TEST_F(PoseMistakes, SideThatContradictsTheFrame) {
  write("scan.nrrd", block_nrrd());
  EXPECT_EQ(check(scan_scenario("left", "[1, 0, 0]", "[0, 0, 1]")).err, "") << "a left glenoid faces left, +x in LPS";
  const ProgramResult wrong = check(scan_scenario("right", "[1, 0, 0]", "[0, 0, 1]"));
  EXPECT_EQ(wrong.status, 0) << "a specimen may lie in the scanner as it likes";
  EXPECT_THAT(wrong.err, AllOf(HasSubstr("bone.side is right, but the glenoid's normal points to the patient's left"),
                               HasSubstr("x = 1.00")));
  const ProgramResult done = run(scan_scenario("right", "[1, 0, 0]", "[0, 0, 1]"));
  expect_done(done);
  EXPECT_THAT(done.err, HasSubstr("bone.side is right, but"));
  EXPECT_THAT(read("out/summary.json"), HasSubstr("bone.side is right, but"));
}

TEST_F(PoseMistakes, SuperiorThatPointsDown) {
  write("scan.nrrd", block_nrrd());
  EXPECT_THAT(
      check(scan_scenario("left", "[1, 0, 0]", "[0, 0.2, -0.9]")).err,
      AllOf(HasSubstr("superior direction points down"), HasSubstr("z = -0.98"), HasSubstr("bone.glenoid.superior")));
}

TEST_F(PoseMistakes, AMeshHasNoSidesOfItsOwn) {
  const std::string yaml = cube_scenario("center_mm: [0, 20, 20], normal: [-1, 0, 0], superior: [0, 0, -1]");
  EXPECT_EQ(check(yaml).err, "");
}

TEST_F(PoseMistakes, OnARealShoulder) {
  const std::string scan = data_file("shoulder_ct/shoulder_left.nrrd");
  if (!std::filesystem::exists(scan)) GTEST_SKIP() << "no " << scan << "; set REAMSIM_DATA";
  const auto said = [&](const std::string& voxel_mm, std::vector<std::string> options,
                        const std::vector<std::string>& more) {
    options.insert(options.begin(),
                   {"check", REAMSIM_ROOT "/trajectories/ct_shoulder.yaml", "--set", "bone.voxel_mm=" + voxel_mm});
    for (const std::string& set : more) options.insert(options.end(), {"--set", set});
    return reamsim({.arguments = options, .environment = {}, .folder = "", .interrupt_when = {}});
  };
  const auto wrong = [&](const std::vector<std::string>& more) { return said("1.2", kQuickShoulder, more); };
  EXPECT_EQ(said("0.8", {}, {"render.enabled=false"}).err, "") << "as it is, there is nothing to be said";
  EXPECT_THAT(wrong({"bone.side=right", "bone.glenoid.superior=[0.54, -0.24, -0.81]"}).err,
              AllOf(HasSubstr("points to the patient's left"), HasSubstr("x = 0.61"),
                    HasSubstr("superior direction points down")));
  expect_refused(wrong({"bone.glenoid.normal=[-0.611, 0.548, -0.572]"}), 2, {"bone.glenoid.normal", "into the bone"});
  expect_refused(wrong({"bone.glenoid.center_mm=[139.1, 165, -429.2]"}), 2, {"bone.glenoid.center_mm", "mm outside"});
}

TEST_F(PoseMistakes, FindingsComeBeforeTheScenario) {
  const ProgramResult result = check(with(cube_scenario(kRight), "plunge: {", "plunge: {spin_rpm: 0, "));
  EXPECT_EQ(result.status, 0) << result.err;
  const std::size_t scenario = result.out.find("\nversion: 2\n");
  ASSERT_NE(scenario, std::string::npos) << result.out;
  for (const char* finding : {"# warning: spindle speed is zero", "# memory: ", "# time: about "}) {
    EXPECT_LT(result.out.find(finding), scenario) << finding;
  }
  EXPECT_EQ(result.out.find("\n#", scenario), std::string::npos) << "nothing after it";
}

TEST_F(PoseMistakes, TimeGrowsWithTheFrames) {
  const std::string yaml = with(cube_scenario(kRight), "dwell_s: 0", "dwell_s: 2");
  const double once_s = number_after(check(yaml).out, "# time: about ");
  const double long_s = number_after(check(yaml, {"--set", "motion.plunge.dwell_s=200"}).out, "# time: about ");
  EXPECT_GT(once_s, 0);
  EXPECT_GT(long_s, 3 * once_s);
}

}  // namespace
}  // namespace reamsim::test
