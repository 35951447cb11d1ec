// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Shipped scenarios and studies by their names; the place of the installation is tested by tests/package.
#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Shipped : public CliTest {
 protected:
  ProgramResult call(std::vector<std::string> arguments) const {
    return reamsim({.arguments = std::move(arguments), .environment = {}, .folder = "", .interrupt_when = {}});
  }
  /// run of half_space in a fraction of a second.
  ProgramResult run_quickly(const std::string& scenario) const {
    return call({"run", scenario, "--device", "serial", "--set", "bone.voxel_mm=1", "--set", "motion.frame_rate_hz=50",
                 "--set", "motion.plunge.feed_mm_s=5", "--set", "render.enabled=false"});
  }
};

TEST_F(Shipped, ScenarioByNameGivesTheBytesOfItsFile) {
  const ProgramResult named = run_quickly("half_space");
  EXPECT_EQ(named.status, 0) << named.err;
  const std::string forces = read("out/half_space/forces.csv"), scenario = read("out/half_space/scenario.yaml");
  std::filesystem::remove_all(path("out"));
  EXPECT_EQ(run_quickly(REAMSIM_ROOT "/trajectories/half_space.yaml").status, 0);
  EXPECT_TRUE(read("out/half_space/forces.csv") == forces);
  EXPECT_EQ(read("out/half_space/scenario.yaml"), scenario);
}

TEST_F(Shipped, UnknownNameListsTheNamesThereAre) {
  for (const char* command : {"run", "check"}) {
    expect_refused(call({command, "nonsense"}), 2,
                   {"nonsense: no such file, and no shipped scenario of this name", "compliance, ct_shoulder, ",
                    "default, ", "half_space", "study_uniconcave_flat"});
  }
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"sweep", "plan"}, {"sweep", "run"}, {"uq"}}) {
    std::vector<std::string> arguments = command;
    arguments.emplace_back("nonsense");
    expect_refused(call(arguments), 2,
                   {"no shipped study of this name", "breakthrough, reamers, resolution, shoulder_errors",
                    "validation/augments, validation/drilling, validation/foam, validation/pegs"});
  }
}

TEST_F(Shipped, StudyIsNoScenario) {
  expect_refused(call({"run", "reamers"}), 2, {"reamers: is a shipped study, not a scenario; use reamsim sweep"});
  expect_refused(call({"sweep", "plan", "default"}), 2,
                 {"default: is a shipped scenario, not a study; use reamsim run"});
}

TEST_F(Shipped, WhatExistsIsAPath) {
  write("default", with(kSmall, "version: 2", "version: 2\nname: own"));
  EXPECT_THAT(call({"check", "default"}).out, HasSubstr("own"));
  std::filesystem::create_directory(path("half_space"));
  expect_refused(call({"check", "half_space"}), 2, {"half_space: is a folder"});
}

TEST_F(Shipped, PathsAreNoNames) {
  for (const char* missing :
       {"./default", "trajectories/default", "trajectories/default.yaml", "nix.yaml", "/default"}) {
    const ProgramResult result = call({"check", missing});
    expect_refused(result, 2, {"no such file"});
    EXPECT_THAT(result.err, Not(HasSubstr("shipped"))) << missing;
  }
}

TEST_F(Shipped, FileThatIsMissingMayBeMeantAsAName) {
  for (const char* command : {"run", "import", "preview"}) {
    expect_refused(call({command, "default.yaml", "-o", "out"}), 2,
                   {"default.yaml: no such file; use `default` (without .yaml), the shipped scenario"});
  }
  expect_refused(call({"check", "half_space.yml"}), 2, {"use `half_space` (without .yml), the shipped scenario"});
  expect_refused(call({"sweep", "plan", "reamers.yaml"}), 2,
                 {"reamers.yaml: no such file; use `reamers` (without .yaml), the shipped study"});
  write("study.yaml", "version: 1\nbase: default.yaml\nset: {bone.voxel_mm: 1}\n");
  expect_refused(call({"sweep", "plan", "study.yaml"}), 2,
                 {"study.yaml:2:7: base: no such file: default.yaml; use `default` (without .yaml)"});
  write("default.yaml", with(kSmall, "version: 2", "version: 2\nname: own"));
  EXPECT_THAT(call({"check", "default.yaml"}).out, HasSubstr("own"));
}

TEST_F(Shipped, StudyByName) {
  const ProgramResult status = call({"sweep", "submit", "reamers", "--parallel", "--to", "scripts"});
  EXPECT_EQ(status.status, 0) << status.err;
  EXPECT_THAT(read("scripts/reamers.parallel.sh"), HasSubstr("/trajectories/studies/reamers.yaml"));
  EXPECT_EQ(call({"sweep", "submit", "validation/drilling", "--parallel", "--to", "more"}).status, 0);
  EXPECT_THAT(read("more/drilling.parallel.sh"), HasSubstr("/trajectories/validation/drilling.yaml"));
}

/// `sweep plan` of a study in the folder `part`.
TEST_F(Shipped, BaseOfAStudy) {
  std::filesystem::create_directory(path("part"));
  const auto plan = [&](const std::string& base) {
    write("part/study.yaml", "version: 1\nbase: " + base + "\nset: {bone.voxel_mm: 1}\n");
    return call({"sweep", "plan", "part/study.yaml", "--set", "engine.device=serial"});
  };
  write("half_space", "not beside the study\n");
  EXPECT_THAT(plan("half_space").out, HasSubstr("1 runs of " REAMSIM_ROOT "/trajectories/half_space.yaml"));
  write("part/half_space", kSmall);
  EXPECT_THAT(plan("half_space").out, HasSubstr("1 runs of " + path("part/half_space")));
  expect_refused(plan("nonsense"), 2,
                 {"part/study.yaml:2:7: base: nonsense: no such file, and no shipped scenario of this name; expected a "
                  "file (YAML) or one of compliance, ct_shoulder, ",
                  "study_uniconcave_flat"});
  expect_refused(plan("./default"), 2, {"part/study.yaml:2:7: base: no such file: ", "part/default; expected a file"});
}

TEST_F(Shipped, BonesAndScenariosOfImportAndPreview) {
  EXPECT_EQ(call({"import", "half_space", "-o", "bone.vdb", "--set", "bone.voxel_mm=1"}).status, 0);
  EXPECT_EQ(call({"preview", "half_space", "-o", "page.html"}).status, 0);
  expect_refused(call({"import", "nonsense", "-o", "other.vdb"}), 2, {"nonsense", "no such file"});
}

}  // namespace
}  // namespace reamsim::test
