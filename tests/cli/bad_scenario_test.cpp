// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

class BadScenario : public CliTest {
 protected:
  ProgramResult changed(const std::string& from, const std::string& to) const { return run(with(kSmall, from, to)); }
};

TEST_F(BadScenario, TheSmallOneIsFine) {
  expect_done(run(kSmall));
}

TEST_F(BadScenario, NoSuchFile) {
  const ProgramResult result =
      reamsim({.arguments = {"run", "nix.yaml", "-o", "out"}, .environment = {}, .folder = "", .interrupt_when = {}});
  expect_refused(result, 2, {"nix.yaml: no such file"});
}

TEST_F(BadScenario, Folder) {
  const ProgramResult result =
      reamsim({.arguments = {"run", ".", "-o", "out"}, .environment = {}, .folder = "", .interrupt_when = {}});
  expect_refused(result, 2, {".: is a folder", "expected a scenario file"});
}

TEST_F(BadScenario, EmptyFile) {
  expect_refused(run(""), 2, {"s.yaml: is empty"});
}

TEST_F(BadScenario, SyntaxError) {
  expect_refused(changed("[10, 10, 6]", "[10, 10, 6"), 2, {"s.yaml:7:14: YAML syntax error"});
}

TEST_F(BadScenario, UnknownKey) {
  expect_refused(changed("voxel_mm", "voxl_mm"), 2, {"s.yaml:4:3: bone.voxl_mm: unknown key; did you mean voxel_mm"});
}

TEST_F(BadScenario, MissingKey) {
  expect_refused(changed("  source: phantom\n", ""), 2, {"s.yaml:2:1: bone.source: missing"});
}

TEST_F(BadScenario, WrongType) {
  expect_refused(changed("voxel_mm: 0.5", "voxel_mm: small"), 2,
                 {"s.yaml:4:13: bone.voxel_mm: found the text \"small\"; expected a number"});
}

TEST_F(BadScenario, OutOfRange) {
  expect_refused(changed("voxel_mm: 0.5", "voxel_mm: -1"), 2, {"s.yaml:4:13: bone.voxel_mm: found -1", "0.01 to 5"});
}

TEST_F(BadScenario, NotANumber) {
  expect_refused(changed("feed_mm_s: 5", "feed_mm_s: .nan"), 2,
                 {"s.yaml:14:16: motion.plunge.feed_mm_s: found .nan", "not finite"});
}

TEST_F(BadScenario, WrongUnitSuffix) {
  expect_refused(changed("feed_mm_s", "feed_mm_min"), 2,
                 {"s.yaml:14:5: motion.plunge.feed_mm_min: unknown key; did you mean feed_mm_s (mm/s)?"});
}

TEST_F(BadScenario, ToolThatIsMissing) {
  expect_refused(changed("assets/reamer_flat.stl", "assets/nix.stl"), 2, {"s.yaml:9:9: tool.mesh: no such file"});
}

TEST_F(BadScenario, UnsetVariable) {
  expect_refused(run(with_bone("  source: ct\n  ct: {path: \"${REAMSIM_TEST_UNSET}/x.nrrd\"}\n")), 2,
                 {"s.yaml:4:14: bone.ct.path", "REAMSIM_TEST_UNSET", "not set"});
}

TEST_F(BadScenario, ToolLargerThanMemoryAllows) {
  expect_refused(changed("reamer_flat.stl\n", "reamer_flat.stl\n  scale: 1000\n"), 2,
                 {"reamer_flat.stl", "tool.scale"});
  expect_refused(
      run(with(with(kSmall, "reamer_flat.stl\n", "reamer_flat.stl\n  scale: 30\n"), "voxel_mm: 0.5", "voxel_mm: 0.1") +
          "cutting: {erosion: remove}\n"),
      2, {"tool", "4096"});
  expect_refused(changed("reamer_flat.stl\n", "reamer_flat.stl\n  shell_resolution: 100000\n"), 2,
                 {"s.yaml:10:21: tool.shell_resolution: found 100000", "0 to 4096"});
}

TEST_F(BadScenario, BoneLargerThanMemoryAllows) {
  expect_refused(run(with(with(kSmall, "voxel_mm: 0.5", "voxel_mm: 0.01"), "[10, 10, 6]", "[1000, 1000, 1000]")), 2,
                 {"bone", "voxel"});
}

TEST_F(BadScenario, KeyframesThatGoBackInTime) {
  const std::string motion = kSmall.substr(kSmall.find("  plunge:"), kSmall.find("render:") - kSmall.find("  plunge:"));
  expect_refused(changed(motion,
                         "  keyframes:\n"
                         "    - {time_s: 1, position_mm: [0, 0, 1], axis: [0, 0, 1]}\n"
                         "    - {time_s: 0.5, position_mm: [0, 0, 0], axis: [0, 0, 1]}\n"),
                 2, {"s.yaml:14:8: motion.keyframes.1.time_s: found 0.5", "later"});
}

TEST_F(BadScenario, RecordedPosesThatGoBackInTime) {
  const std::string motion = kSmall.substr(kSmall.find("  plunge:"), kSmall.find("render:") - kSmall.find("  plunge:"));
  write("poses.csv",
        "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n"
        "0,0,0,1,1,0,0,0\n"
        "0.2,0,0,0.5,1,0,0,0\n"
        "0.1,0,0,0,1,0,0,0\n");
  expect_refused(changed(motion, "  csv: {path: poses.csv}\n"), 2, {"poses.csv:4", "time_s", "0.1"});
  write("poses.csv", "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,1,1,0,0,0\n0.2,0,nan,0.5,1,0,0,0\n");
  expect_refused(changed(motion, "  csv: {path: poses.csv}\n"), 2, {"poses.csv:3", "y_mm"});
  write("poses.csv", "");
  expect_refused(changed(motion, "  csv: {path: poses.csv}\n"), 2, {"poses.csv"});
}

TEST_F(BadScenario, ToolThatNeverTouchesIsAWarning) {
  const ProgramResult result = changed("    depth_mm: 1\n", "    depth_mm: 0\n    entry_mm: [0, 0, 5]\n");
  expect_done(result);
  EXPECT_THAT(result.err, HasSubstr("reamsim: warning: "));
  EXPECT_THAT(result.err, HasSubstr("never touches the bone"));
}

}  // namespace
}  // namespace reamsim::test
