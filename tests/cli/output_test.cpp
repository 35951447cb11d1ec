// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

class Output : public CliTest {
 protected:
  ProgramResult limited(const std::string& yaml, long bytes) const {
    write("s.yaml", yaml);
    return reamsim({.arguments = {"run", "s.yaml", "-o", "out"},
                    .environment = {},
                    .folder = "",
                    .file_size_limit = bytes,
                    .interrupt_when = {}});
  }
};

TEST_F(Output, IsComplete) {
  plots_ = true;
  expect_done(run(kSmall));
  for (const char* file : {"scenario.yaml", "forces.csv", "forces.png", "forces.svg", "forces.gp", "reamed.vdb",
                           "reamed.vti", "planning.mrk.json", "forces.pdf", "reamed.glb", "reamed.stl", "summary.json",
                           "timings.csv", "snapshots/000000.vdb", "snapshots/tool.stl"}) {
    EXPECT_TRUE(exists(std::string("out/") + file)) << file;
  }
  const std::string forces = read("out/forces.csv");
  EXPECT_TRUE(forces.starts_with(
      "frame,time_s,tool_x_mm,tool_y_mm,tool_z_mm,tool_qw,tool_qx,tool_qy,tool_qz,spin_rpm,spin_angle_rad,depth_mm,"
      "force_x_n,force_y_n,force_z_n,torque_x_nmm,torque_y_nmm,torque_z_nmm,axial_force_n,spin_torque_nmm,contacts,"
      "removed_mm3,energy_mj,floor_energy_mj,balance,pass\n"));
  EXPECT_GT(std::count(forces.begin(), forces.end(), '\n'), 35);
}

TEST_F(Output, OfADraftIsCoarseAndSaysSo) {
  meshes_ = plots_ = true;
  write("s.yaml", with(kSmall, "  enabled: false\n", "  width_px: 96\n  height_px: 72\n"));
  const auto draft = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"run", "s.yaml", "--draft", "--overwrite"});
    return reamsim({.arguments = std::move(more), .environment = {}, .folder = "", .interrupt_when = {}});
  };
  const ProgramResult result = draft({});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("with voxels of 1 mm, forces and volumes differ"));
  EXPECT_THAT(read("out/s-draft/summary.json"), HasSubstr("a draft with few pictures"));
  for (const char* file : {"reamed.png", "forces.png"}) EXPECT_TRUE(exists(std::string("out/s-draft/") + file)) << file;
  for (const char* file : {"report.html", "reamed.vti", "reamed.stl", "reamed_section.png", "contact_sheet.png",
                           "plots/energy.png", "plots/removed_density.png"}) {
    EXPECT_FALSE(exists(std::string("out/s-draft/") + file)) << file;
  }
  EXPECT_EQ(draft({"--set", "bone.voxel_mm=0.7", "--set", "output.vti=true", "--set", "output.plots=true"}).status, 0);
  EXPECT_THAT(read("out/s-draft/scenario.yaml"), HasSubstr("voxel_mm: 0.7"));
  EXPECT_TRUE(exists("out/s-draft/reamed.vti"));
  EXPECT_TRUE(exists("out/s-draft/plots/energy.png"));
}

#ifndef __SANITIZE_ADDRESS__  // whose own memory would be measured
TEST_F(Output, CheckForetellsTheMemoryThatARunTakes) {
  const std::string sphere =
      with_bone("  source: phantom\n  voxel_mm: 0.1\n  phantom:\n    shape: sphere\n    radius_mm: 7\n");
  expect_done(run(sphere));
  const ProgramResult check =
      reamsim({.arguments = {"check", "s.yaml"}, .environment = {}, .folder = "", .interrupt_when = {}});
  EXPECT_EQ(check.status, 0) << check.err;
  const double foretold_mb = number_after(check.out, "on the device, up to ");
  const double taken_mb = number_after(read("out/summary.json"), "\"peak_process\": ");
  EXPECT_GT(foretold_mb, taken_mb / 1.5);
  EXPECT_LT(foretold_mb, taken_mb * 1.5);
}
#endif

TEST_F(Output, ResolvedScenarioRunsAgainToTheSameBytes) {
  expect_done(run(kSmall));
  const std::string forces = read("out/forces.csv");
  const ProgramResult again = reamsim({.arguments = {"run", "out/scenario.yaml", "-o", "again"},
                                       .environment = {},
                                       .folder = "",
                                       .interrupt_when = {}});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_TRUE(read("again/forces.csv") == forces);
}

TEST_F(Output, FolderThatExistsIsLeftAlone) {
  std::filesystem::create_directory(path("out"));
  write("out/mine.txt", "keep");
  const ProgramResult result = run(kSmall);
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.err, HasSubstr("out: "));
  EXPECT_THAT(result.err, HasSubstr("--overwrite"));
  EXPECT_EQ(read("out/mine.txt"), "keep");
  EXPECT_FALSE(exists("out.partial"));
}

TEST_F(Output, OverwriteReplacesAfterSuccessOnly) {
  expect_done(run(kSmall));
  const std::string first = read("out/forces.csv");
  const ProgramResult failed = run(with(kSmall, "voxel_mm: 0.5", "voxel_mm: 0"), {"--overwrite"});
  EXPECT_EQ(failed.status, 2);
  EXPECT_EQ(read("out/forces.csv"), first);
  EXPECT_FALSE(exists("out.partial"));
  const ProgramResult tool_failed =
      run(with(kSmall, "reamer_flat.stl\n", "reamer_flat.stl\n  scale: 1000\n"), {"--overwrite"});
  EXPECT_EQ(tool_failed.status, 2) << tool_failed.err;
  EXPECT_EQ(read("out/forces.csv"), first);
  EXPECT_FALSE(exists("out.partial"));
  expect_done(run(with(kSmall, "depth_mm: 1", "depth_mm: 1.5"), {"--overwrite"}));
  EXPECT_NE(read("out/forces.csv"), first);
  EXPECT_FALSE(exists("out.old"));
}

TEST_F(Output, NameOfAFile) {
  write("out", "mine");
  const ProgramResult result = run(kSmall, {"--overwrite"});
  EXPECT_EQ(result.status, 2) << result.err;
  EXPECT_EQ(read("out"), "mine");
  EXPECT_FALSE(exists("out.partial"));
}

TEST_F(Output, NotWritable) {
  // The tests may run as root, whom permissions do not stop: below a file, and in /proc, nobody can make a folder.
  write("s.yaml", kSmall);
  for (const std::string place : {"s.yaml/out", "/proc/reamsim-out"}) {
    const ProgramResult result =
        reamsim({.arguments = {"run", "s.yaml", "-o", place}, .environment = {}, .folder = "", .interrupt_when = {}});
    expect_refused(result, 2, {place.c_str(), "output folder"});
  }
  EXPECT_EQ(read("s.yaml"), kSmall);
}

TEST_F(Output, DiskFullAtOnce) {
  // Less than the first file of the results; more than the message, which goes to a file too.
  expect_refused(limited(kSmall, 280), 1, {"out.partial/", "cannot be written", "disk"});
}

TEST_F(Output, DiskFullLaterKeepsFinishedFrames) {
  // The tool's mesh of 144 kB fits, the log of 6,000 frames does not.
  const ProgramResult result = limited(with(kSmall, "dwell_s: 0", "dwell_s: 60"), 150'000);
  EXPECT_EQ(result.signal, 0) << result.err;
  EXPECT_EQ(result.status, 1) << result.err;
  EXPECT_THAT(result.err, HasSubstr("cannot be written"));
  EXPECT_THAT(result.err, HasSubstr("out.partial")) << "the message says what is kept";
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_FALSE(exists("out"));
  EXPECT_GT(read("out.partial/forces.csv").size(), 10'000u);
}

TEST_F(Output, DiskFullAtTheVdb) {
  // The logs of 40 frames and the tool's mesh fit, the grid of twice as much bone does not.
  const ProgramResult result = limited(with(kSmall, "[10, 10, 6]", "[20, 20, 20]"), 150'000);
  EXPECT_EQ(result.signal, 0) << result.err;
  EXPECT_EQ(result.status, 1) << result.err;
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_FALSE(exists("out"));
}

TEST_F(Output, InterruptKeepsFinishedFrames) {
  write("s.yaml", with(kSmall, "dwell_s: 0", "dwell_s: 3600") + "output: {checkpoint_s: 0}\n");
  const auto has_rows = [this] {
    std::error_code missing;
    const auto size = std::filesystem::file_size(path("out.partial/forces.csv"), missing);
    return !missing && size > 20'000;
  };
  const ProgramResult result = reamsim(
      {.arguments = {"run", "s.yaml", "-o", "out"}, .environment = {}, .folder = "", .interrupt_when = has_rows});
  EXPECT_EQ(result.signal, 0);
  EXPECT_EQ(result.status, 130) << result.err;
  EXPECT_THAT(result.err, HasSubstr("interrupted"));
  EXPECT_THAT(result.err, HasSubstr("out.partial"));
  EXPECT_FALSE(exists("out"));
  const std::string forces = read("out.partial/forces.csv");
  EXPECT_GT(forces.size(), 20'000u);
  EXPECT_TRUE(forces.ends_with("\n")) << "whole rows";
}

TEST_F(Output, NewRunAfterAnInterruptedOne) {
  std::filesystem::create_directory(path("out.partial"));
  write("out.partial/forces.csv", "frame\n");
  const ProgramResult refused = run(kSmall);
  EXPECT_EQ(refused.status, 2) << refused.err;
  EXPECT_THAT(refused.err, HasSubstr("out.partial"));
  EXPECT_TRUE(exists("out.partial/forces.csv"));
  expect_done(run(kSmall, {"--overwrite"}));
}

TEST_F(Output, QuietSaysNothing) {
  const ProgramResult result = run(kSmall, {"--quiet"});
  expect_done(result);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "");
}

}  // namespace
}  // namespace reamsim::test
