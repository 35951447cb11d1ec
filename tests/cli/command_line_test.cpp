// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/cli/cli_fixture.h"
#include "tests/cli/data_files.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

class CommandLine : public CliTest {
 protected:
  ProgramResult call(const std::vector<std::string>& arguments) const {
    return reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
  }
};

TEST_F(CommandLine, NoCommandPrintsTheHelpAndFails) {
  const ProgramResult nothing = call({});
  EXPECT_EQ(nothing.status, 2);
  EXPECT_EQ(nothing.out, "") << "a script that lacks a command must not take the help for a result";
  EXPECT_EQ(nothing.err, call({"--help"}).out);
  for (const char* text : {"Usage: reamsim", "  run ", "Exit status:", "  75 "})
    EXPECT_THAT(nothing.err, HasSubstr(text));
  expect_refused(call({"sweep"}), 2, {"see reamsim sweep --help"});
}

TEST_F(CommandLine, UnknownCommand) {
  expect_refused(call({"polish", "s.yaml"}), 2, {"polish"});
}

TEST_F(CommandLine, MissingArgument) {
  expect_refused(call({"run"}), 2, {"SCENARIO"});
  expect_refused(call({"check"}), 2, {"SCENARIO"});
  expect_refused(call({"render"}), 2, {"DIR"});
  expect_refused(call({"import"}), 2, {"required"});
}

TEST_F(CommandLine, UnknownOption) {
  write("s.yaml", kSmall);
  expect_refused(call({"run", "s.yaml", "--turbo"}), 2, {"--turbo"});
  expect_refused(call({"run", "s.yaml", "--restart"}), 2, {"--restart"});
}

TEST_F(CommandLine, OptionWithoutItsValue) {
  write("s.yaml", kSmall);
  plots_ = true;  // nothing follows the option
  expect_refused(call({"run", "s.yaml", "-o"}), 2, {"--output"});
}

TEST_F(CommandLine, HelpAndVersion) {
  const ProgramResult help = call({"--help"});
  EXPECT_EQ(help.status, 0) << help.err;
  for (const char* command : {"run", "check", "render", "import", "preview", "devices"})
    EXPECT_THAT(help.out, HasSubstr(command));
  const ProgramResult version = call({"--version"});
  EXPECT_EQ(version.status, 0);
  EXPECT_THAT(version.out, HasSubstr("reamsim "));
  EXPECT_THAT(version.out, HasSubstr("Apache License, Version 2.0"));
  EXPECT_THAT(version.out, HasSubstr("Copyright the reamsim authors"));
  for (const char* part : {"OpenVDB 1", "Eigen ", "ITK 5.", "yaml-cpp 0.", "assimp ", "libpng 1.", "OpenCL: "}) {
    EXPECT_THAT(version.out, HasSubstr(part));
  }
  EXPECT_EQ(call({"-V"}).out, version.out);
}

TEST_F(CommandLine, ARunSaysWhereToLook) {
  const ProgramResult plain = run(kSmall);
  EXPECT_THAT(plain.out, HasSubstr("results: " + path("out") + "\nlook first at " + path("out/summary.json\n")));
}

/// A program on a terminal of its own; what it wrote there.
std::string on_terminal(const std::string& command, const std::string& folder, const std::string& setting) {
  const ProgramResult result = run_program(
      "/bin/sh",
      {.arguments = {"-c", "script -qec '" + setting + " " REAMSIM_PROGRAM " " + command + "' /dev/null; true"},
       .environment = {{"TERM", "xterm"}},
       .folder = folder,
       .interrupt_when = {}});
  return result.out;
}

TEST_F(CommandLine, ColoursOnATerminalOnly) {
  EXPECT_THAT(on_terminal("run nix.yaml", dir_, "env"), HasSubstr("\033[31mreamsim: error:\033[0m nix.yaml"));
  for (const char* setting : {"env NO_COLOR=1", "env TERM=dumb"}) {
    const std::string plain = on_terminal("run nix.yaml", dir_, setting);
    EXPECT_THAT(plain, HasSubstr("reamsim: error: nix.yaml")) << setting;
    EXPECT_THAT(plain, ::testing::Not(HasSubstr("\033"))) << setting;
  }
  EXPECT_THAT(on_terminal("run nix.yaml", dir_, "env NO_COLOR="), HasSubstr("\033[31m")) << "empty is not set";
  EXPECT_THAT(call({"run", "nix.yaml"}).err, ::testing::Not(HasSubstr("\033")));
}

TEST_F(CommandLine, ImportDrawsABarOnATerminal) {
  write("cube.stl", cube_stl(30));
  const std::string drawn = on_terminal("import cube.stl -o bone.vdb --set bone.voxel_mm=1", dir_, "env");
  EXPECT_THAT(drawn, HasSubstr("\rimport [" + std::string(30, '.') + "] 0 %: reading the mesh"));
  EXPECT_THAT(drawn, HasSubstr("\rimport [" + std::string(30, '#') + "] 100 %, 0 s left"));
}

TEST_F(CommandLine, Devices) {
  const ProgramResult result = call({"devices"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("serial"));
}

TEST_F(CommandLine, CheckPrintsTheResolvedScenarioAndItsCostAndTouchesNothing) {
  write("s.yaml", kSmall);
  const ProgramResult result = call({"check", "s.yaml", "--set", "motion.plunge.depth_mm=1.5"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.err, "");
  for (const char* text : {"version: 2\n", "  voxel_mm: 0.5\n", "    depth_mm: 1.5\n", "frames", "substeps", "voxels",
                           "MB", "# time: about "}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  int entries = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(dir_)) ++entries;
  EXPECT_EQ(entries, 1) << "only s.yaml";
  write("again.yaml", result.out);
  const ProgramResult again = call({"check", "again.yaml"});
  EXPECT_EQ(again.status, 0) << again.err;
  const auto without_times = [](std::string text) {
    for (std::size_t at = text.find("# time: "); at != std::string::npos; at = text.find("# time: ")) {
      text.erase(at, text.find('\n', at) + 1 - at);
    }
    return text;
  };
  EXPECT_EQ(without_times(again.out), without_times(result.out)) << "what check prints is a scenario, and the same one";
}

TEST_F(CommandLine, ACoarseShellLeaksOnlyWhereItCuts) {
  write("s.yaml", kSmall);
  const auto check = [&](const std::string& erosion, const std::string& engine) {
    return call({"check", "s.yaml", "--set", "tool.shell_resolution=12", "--set", "cutting.erosion=" + erosion, "--set",
                 "engine.type=" + engine});
  };
  EXPECT_EQ(check("exact", "exact").err, "");
  EXPECT_EQ(check("remove", "implicit").err, "");
  EXPECT_THAT(check("remove", "bricked").err, HasSubstr("of the swept voxels may survive"));
}

TEST_F(CommandLine, SetErrorsNameTheAssignment) {
  expect_refused(run(kSmall, {"--set", "bone.voxel_mm=9"}), 2,
                 {"--set bone.voxel_mm=9: bone.voxel_mm: found 9", "0.01 to 5"});
  expect_refused(run(kSmall, {"--set", "bone.voxel_mm"}), 2, {"--set bone.voxel_mm: found no \"=\""});
}

TEST_F(CommandLine, EngineIsOneOfTheList) {
  expect_refused(run(kSmall, {"--engine", "fast"}), 2,
                 {"engine.type", "fast", "expected auto, exact, bricked, direct, octree or implicit"});
  expect_refused(run(kSmall, {"--engine", "implicit", "--set", "cutting.law=per_point"}), 2,
                 {"cutting.law", "per_point", "energy", "implicit"});
}

TEST_F(CommandLine, RenderOfNothing) {
  expect_refused(call({"render", "nix"}), 2, {"nix", "not found"});
  std::filesystem::create_directory(path("empty"));
  expect_refused(call({"render", "empty"}), 2, {"empty"});
}

TEST_F(CommandLine, ImportMistakes) {
  expect_refused(call({"import", "nix.nrrd", "-o", "b.vdb"}), 2, {"nix.nrrd", "no such file"});
  expect_refused(call({"import", "nix.nrrd", "-o", "b.txt"}), 2, {"b.txt"});
  write("b.vdb", "mine");
  expect_refused(call({"import", "nix.nrrd", "-o", "b.vdb"}), 2, {"b.vdb", "exists", "--overwrite"});
  EXPECT_EQ(read("b.vdb"), "mine");
  EXPECT_FALSE(exists("b.vdb.partial"));
}

}  // namespace
}  // namespace reamsim::test
