// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// motion.plunge.from: contact, from the command line.
#include "tests/cli/cli_fixture.h"
#include "tests/support/real_data.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::string kFromContact = with(kSmall, "  plunge:\n", "  plunge:\n    from: contact\n");

class PlungeContact : public CliTest {
 protected:
  ProgramResult call(const std::vector<std::string>& arguments) const {
    return reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
  }
};

TEST_F(PlungeContact, IsReportedAndItsScenarioRunsAgain) {
  // The entry lies 3.7 mm above the block, out of reach of a plunge of 1 mm from it.
  const ProgramResult first = run(with(kFromContact, "    approach_mm", "    entry_mm: [0, 0, 3.7]\n    approach_mm"));
  expect_done(first);
  const std::string summary = read("out/summary.json");
  EXPECT_NEAR(number_after(summary, "\"travel_mm\": "), 3.7, 1e-6);
  EXPECT_NEAR(number_after(summary, "\"max_depth_mm\": "), 1, 0.05);
  const std::string resolved = read("out/scenario.yaml");
  EXPECT_THAT(resolved, HasSubstr("Found: plunge: first contact 3.7000 mm beyond entry_mm"));
  EXPECT_THAT(resolved, HasSubstr("from: contact"));
  const std::string forces = read("out/forces.csv");
  write("again.yaml", resolved);
  const ProgramResult again = call({"run", "again.yaml", "-o", "again"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(read("again/forces.csv"), forces);
  const ProgramResult checked = call({"check", "s.yaml"});
  EXPECT_THAT(checked.out, HasSubstr("# plunge: first contact 3.7000 mm beyond entry_mm, at the point ("));
}

TEST_F(PlungeContact, BesideTheBoneIsAMistakeOfTheEntry) {
  expect_refused(run(with(kFromContact, "    approach_mm", "    entry_mm: [90, 0, 0]\n    approach_mm")), 2,
                 {"s.yaml:14:", "motion.plunge.entry_mm: the tool meets no bone on the line of the plunge"});
}

TEST_F(PlungeContact, IsFoundWhereOnlyACoarseRayMeetsIt) {
  const ProgramResult checked = call({"check", "default", "--set", "bone.voxel_mm=0.5", "--set",
                                      "motion.plunge={from: contact, "
                                      "entry_mm: [0.546, -0.824, 2.322], axis: [0.1873, -0.048, -0.9811], approach_mm: "
                                      "1, depth_mm: 1, feed_mm_s: 1}"});
  EXPECT_THAT(checked.out, HasSubstr("plunge: first contact")) << checked.err;
}

TEST_F(PlungeContact, ASecondReamerOfTheSameSizeMeetsTheFloor) {
  const std::string tool = "tool: {mesh: " REAMSIM_ROOT "/assets/reamer_flat.stl}\n";
  const std::string plunge =
      "motion: {plunge: {from: contact, approach_mm: 1, feed_mm_s: 10, depth_mm: 2, retract_mm: 4}}\n";
  const std::string rest = tool + plunge + "render: {enabled: false}\n";
  write("first.yaml",
        "version: 2\nbone: {source: phantom, voxel_mm: 0.5, phantom: {shape: half_space, size_mm: [60, 60, 12]}}\n" +
            rest);
  write("second.yaml", "version: 2\nbone: {source: vdb, vdb: {path: first/reamed.vdb}}\n" + rest);
  ASSERT_EQ(call({"run", "first.yaml", "-o", "first"}).status, 0);
  ASSERT_EQ(call({"run", "second.yaml", "-o", "second"}).status, 0);
  const std::string first = read("first/summary.json"), second = read("second/summary.json");
  EXPECT_NEAR(number_after(second, "\"travel_mm\": "), 2 + number_after(first, "\"travel_mm\": "), 0.25);
  const double removed = number_after(first, "\"removed_mm3\": ");
  EXPECT_NEAR(number_after(second, "\"removed_mm3\": "), removed, 0.15 * removed);
}

TEST_F(PlungeContact, FramesOfTinyAdvancesAreWarnedOf) {
  const auto at = [&](const char* rate) {
    return call({"run",
                 "default",
                 "-o",
                 "out",
                 "--overwrite",
                 "--set",
                 "bone.voxel_mm=1",
                 "--set",
                 "render.enabled=false",
                 "--set",
                 "motion.plunge.depth_mm=0.02",
                 "--set",
                 "motion.plunge.approach_mm=0.01",
                 "--set",
                 "motion.plunge.feed_mm_s=0.02",
                 "--set",
                 "motion.plunge.retract_mm=0",
                 "--set",
                 "motion.plunge.dwell_s=0",
                 "--set",
                 std::string("motion.frame_rate_hz=") + rate});
  };
  const ProgramResult slow = at("1000"), usual = at("20");
  ASSERT_EQ(slow.status, 0) << slow.err;
  EXPECT_THAT(slow.err, HasSubstr("peaks of single frames are too large"));
  EXPECT_THAT(usual.err, Not(HasSubstr("peaks of single frames")));
}

TEST_F(PlungeContact, ReamersCompareAtEqualDepthOnAScan) {
  const std::string scan = data_file("shoulder_ct/shoulder_left.nrrd");
  if (!std::filesystem::exists(scan)) GTEST_SKIP() << "no " << scan << "; set REAMSIM_DATA";
  for (const std::string reamer : {"convex", "flat"}) {
    std::vector<std::string> arguments{
        "run",   REAMSIM_ROOT "/trajectories/ct_shoulder.yaml",
        "-o",    reamer,
        "--set", "tool.mesh=" REAMSIM_ROOT "/assets/reamer_" + reamer + ".stl",
        "--set", "motion.frame_rate_hz=100",
        "--set", "motion.plunge={from: contact, approach_mm: 1, depth_mm: 2, feed_mm_s: 2, retract_mm: 4}"};
    arguments.insert(arguments.end(), kQuickShoulder.begin(), kQuickShoulder.end());
    const ProgramResult done = call(arguments);
    ASSERT_EQ(done.status, 0) << done.err;
    EXPECT_NEAR(number_after(read(reamer + "/summary.json"), "\"max_depth_mm\": "), 2, 0.04) << "0.1 voxel; " << reamer;
  }
}

}  // namespace
}  // namespace reamsim::test
