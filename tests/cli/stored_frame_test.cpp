// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// A bone that goes on in a second run, from the VDB of the first or of `reamsim import`.
#include "tests/cli/cli_fixture.h"
#include "tests/cli/data_files.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const std::string kRest =
    "tool:\n  mesh: " REAMSIM_ROOT
    "/assets/reamer_flat.stl\n"
    "motion:\n  frame: glenoid\n  frame_rate_hz: 50\n"
    "  plunge: {approach_mm: 2, feed_mm_s: 4, depth_mm: 1, dwell_s: 0, retract_mm: 2, retract_mm_s: 20}\n"
    "render:\n  enabled: false\nengine:\n  device: serial\n";
const std::string kScan =
    "version: 2\nbone:\n  source: ct\n  side: left\n  voxel_mm: 1\n  ct: {path: scan.nrrd}\n"
    "  glenoid: {center_mm: [14.5, 10, 10], normal: [1, 0, 0], superior: [0, 0, 1]}\n" +
    kRest;

class StoredFrame : public CliTest {
 protected:
  StoredFrame() { write("scan.nrrd", block_nrrd()); }

  static std::string vdb_scenario(const std::string& file) {
    return "version: 2\nbone:\n  source: vdb\n  vdb: {path: " + file + "}\n" + kRest;
  }
  ProgramResult call(const std::vector<std::string>& arguments) const {
    return reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
  }
};

TEST_F(StoredFrame, ASecondRunGoesOnFromTheFirst) {
  expect_done(run(kScan));
  std::filesystem::rename(path("out"), path("first"));
  const ProgramResult again = run(vdb_scenario("first/reamed.vdb"), {"--set", "motion.plunge.depth_mm=2"});
  expect_done(again);
  EXPECT_THAT(read("out/scenario.yaml"), HasSubstr("  side: left\n  voxel_mm: 1\n"));
  // The second takes another millimetre off the same face.
  const double first_mm3 = number_after(read("first/summary.json"), "\"removed_mm3\": ");
  const double second_mm3 = number_after(read("out/summary.json"), "\"removed_mm3\": ");
  EXPECT_GT(first_mm3, 50);
  EXPECT_NEAR(second_mm3 / first_mm3, 1, 0.6);
  std::filesystem::rename(path("out"), path("second"));
  const ProgramResult resolved = call({"check", "second/scenario.yaml"});
  EXPECT_EQ(resolved.status, 0) << resolved.err;
}

// Side and voxels in scenario.yaml are then those of the VDB.
TEST_F(StoredFrame, CompleteResultsOfAVdbAreKnownAgain) {
  expect_done(run(kScan));
  std::filesystem::rename(path("out"), path("first"));
  const std::string scenario = vdb_scenario("first/reamed.vdb");
  expect_done(run(scenario));
  std::filesystem::rename(path("out"), path("out.partial"));
  const ProgramResult other = run(scenario, {"--resume", "--set", "motion.plunge.depth_mm=2"});
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.err, HasSubstr("holds the complete results of another scenario"));
  expect_done(run(scenario, {"--resume"}));
  EXPECT_TRUE(exists("out/forces.csv"));
}

TEST_F(StoredFrame, APushIsCheckedAgainstTheVoxelsOfTheVdb) {
  const std::string fine = with(with(kSmall, "voxel_mm: 0.5", "voxel_mm: 0.2"), "depth_mm: 1\n", "depth_mm: 0.2\n");
  expect_done(run(fine));
  std::filesystem::rename(path("out"), path("first"));
  const std::size_t bone = kSmall.find("bone:\n"), tool = kSmall.find("tool:\n"), plunge = kSmall.find("  plunge:\n");
  const std::string pushed = kSmall.substr(0, bone) + "bone: {source: vdb, vdb: {path: first/reamed.vdb}}\n" +
                             kSmall.substr(tool, plunge - tool) +
                             "  push: {thrust_n: 60, depth_mm: 0.5, max_feed_mm_s: 11}\n" +
                             kSmall.substr(kSmall.find("render:\n"));
  const ProgramResult refused = run(pushed);
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.err, HasSubstr("motion.push.max_feed_mm_s: found 11; expected at most 10"));
}

TEST_F(StoredFrame, ImportOfAScenarioWritesFrameAndSide) {
  write("s.yaml", kScan);
  const ProgramResult made = call({"import", "s.yaml", "-o", "bone.vdb"});
  ASSERT_EQ(made.status, 0) << made.err;
  write("v.yaml", vdb_scenario("bone.vdb"));
  const ProgramResult checked = call({"check", "v.yaml"});
  EXPECT_EQ(checked.status, 0) << checked.err;
  EXPECT_THAT(checked.out, AllOf(HasSubstr("# glenoid frame from the VDB"), HasSubstr("  side: left\n")));
}

TEST_F(StoredFrame, WhatSegmentationDidIsSaidAndShown) {
  const std::string yaml = with(kScan, "enabled: false", "{width_px: 64, height_px: 64, cameras: [glenoid]}");
  const ProgramResult done = run(with(yaml, "render:\n  {", "render: {"));
  expect_done(done);
  EXPECT_THAT(done.out,
              HasSubstr("segmentation: threshold 200 HU, 1 pieces, kept the largest (rank 1 by size); 1000 mm3"));
  const std::string summary = read("out/summary.json");
  EXPECT_EQ(number_after(summary, "\"pieces\": "), 1);
  EXPECT_EQ(number_after(summary, "\"below_threshold_fraction\": "), 0);
  EXPECT_THAT(summary, HasSubstr("\"kept\": \"largest\""));
  EXPECT_TRUE(exists("out/segmentation.png"));
  EXPECT_THAT(read("out/report.html"), AllOf(HasSubstr("outline of the segmented bone"), HasSubstr("Segmented bone")));
  expect_done(run(with(yaml, "render:\n  {", "render: {"), {"--overwrite"}));
  write("v.yaml", vdb_scenario("out/reamed.vdb"));
  EXPECT_THAT(call({"check", "v.yaml"}).out, ::testing::Not(HasSubstr("segmentation: threshold"))) << "a VDB has none";
}

TEST_F(StoredFrame, ImportRefusesAFrameThatContradictsTheBone) {
  write("s.yaml", with(kScan, "normal: [1, 0, 0]", "normal: [-1, 0, 0]"));
  expect_refused(call({"import", "s.yaml", "-o", "bone.vdb"}), 2, {"s.yaml:7:", "points into the bone"});
  EXPECT_FALSE(exists("bone.vdb"));
}

TEST_F(StoredFrame, AFileWithoutAFrameIsSaidAtTheKey) {
  ASSERT_EQ(call({"import", "scan.nrrd", "-o", "bare.vdb"}).status, 0);
  expect_refused(run(vdb_scenario("bare.vdb")), 2, {"s.yaml:8:", "motion.frame", "bone.glenoid is missing"});
}

}  // namespace
}  // namespace reamsim::test
