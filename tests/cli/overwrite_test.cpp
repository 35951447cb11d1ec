// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>
#include <future>
#include <map>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class Overwrite : public CliTest {
 protected:
  ProgramResult call(const std::vector<std::string>& arguments, const std::string& folder = "",
                     const std::map<std::string, std::string>& environment = {}) const {
    return reamsim({.arguments = arguments, .environment = environment, .folder = folder, .interrupt_when = {}});
  }
  /// Every file below a folder with its bytes, folders and links as well.
  std::map<std::string, std::string> contents(const std::string& name) const {
    std::map<std::string, std::string> out;
    for (const auto& entry : fs::recursive_directory_iterator(path(name))) {
      const bool plain = entry.is_regular_file() && !entry.is_symlink();
      out[entry.path().string()] = plain ? file_bytes(entry.path().string()) : "(not a file)";
    }
    return out;
  }
  /// The command ends with status 2, says these words, and `kept` is as it was.
  void expect_kept(const std::string& kept, const std::vector<std::string>& arguments,
                   std::initializer_list<const char*> words, const std::string& folder = "") const {
    const auto before = contents(kept);
    const ProgramResult result = call(arguments, folder);
    EXPECT_EQ(result.status, 2) << ::testing::PrintToString(arguments) << result.out << result.err;
    for (const char* word : words) EXPECT_THAT(result.err, HasSubstr(word));
    EXPECT_EQ(contents(kept), before) << ::testing::PrintToString(arguments);
  }
};

TEST_F(Overwrite, AFolderWithSomethingElseInItIsLeftAlone) {
  write("s.yaml", kSmall);
  expect_done(run(kSmall));
  fs::create_directories(path("thesis/chapters"));
  write("thesis/chapters/one.tex", "years of work");
  fs::create_directory(path("empty_but_for_a_folder"));
  fs::create_directory(path("empty_but_for_a_folder/mine"));
  fs::copy(path("out"), path("annotated"), fs::copy_options::recursive);
  write("annotated/notes.txt", "what I saw");
  fs::copy(path("out"), path("nested"), fs::copy_options::recursive);
  fs::create_directory(path("nested/snapshots/mine"));
  fs::copy(path("out"), path("linked"), fs::copy_options::recursive);
  fs::create_directory_symlink(path("thesis"), path("linked/frames"));
  fs::copy(path("out"), path("only_known_names"), fs::copy_options::recursive);
  fs::remove(path("only_known_names/manifest.json"));
  fs::remove(path("only_known_names/summary.json"));
  fs::remove(path("only_known_names/scenario.yaml"));
  const std::vector<std::pair<std::string, const char*>> folders{
      {"thesis", "chapters"},     {"empty_but_for_a_folder", "mine"},
      {"annotated", "notes.txt"}, {"nested", "snapshots/mine"},
      {"linked", "frames"},       {"only_known_names", "not a finished results folder"}};
  for (const auto& [folder, found] : folders) {
    expect_kept(".", {"run", "s.yaml", "-o", folder, "--overwrite"}, {folder.c_str(), found, "-o"});
    expect_kept(".", {"compare", "out", "only_known_names", "-o", folder, "--overwrite"}, {""});
    expect_kept(".", {"verify", "--quick", "--device", "serial", "-o", folder, "--overwrite"}, {folder.c_str()});
    expect_kept(".", {"bench", "--quick", "-o", folder, "--overwrite"}, {folder.c_str()});
  }
  for (const char* command : {"verify", "bench"}) {
    expect_kept(".", {command, "--quick", "-o", "out", "--overwrite"}, {"out", "holds"});
    expect_kept(".", {command, "--quick", "-o", "thesis"}, {"thesis", "exists already", "--overwrite"});
  }
}

TEST_F(Overwrite, AnUnfinishedFolderWithSomethingElseInItIsLeftAlone) {
  write("s.yaml", kSmall);
  fs::create_directory(path("out.partial"));
  write("out.partial/thesis.tex", "years of work");
  expect_kept(".", {"run", "s.yaml", "-o", "out", "--overwrite"}, {"out.partial", "thesis.tex"});
  expect_kept(".", {"verify", "--quick", "-o", "out", "--overwrite"}, {"out.partial", "thesis.tex"});
}

TEST_F(Overwrite, TheCurrentFolderAndWhatIsAboveItAreLeftAlone) {
  expect_done(run(kSmall));
  fs::create_directories(path("out/plots"));
  write("s.yaml", kSmall);
  const std::string scenario = path("s.yaml");
  for (const std::string& place : {std::string("."), std::string("./"), std::string("../out"), path("out")}) {
    expect_kept(".", {"run", scenario, "-o", place, "--overwrite"}, {"current folder"}, path("out"));
  }
  expect_kept(".", {"run", scenario, "-o", "..", "--overwrite"}, {"current folder"}, path("out/plots"));
  // One level down, so that a mistake takes away no more than the test's own folder.
  fs::create_directories(path("study/inner"));
  fs::copy(path("s.yaml"), path("study/inner/s.yaml"));
  for (const char* place : {".", ".."}) {
    expect_kept(".", {"run", "s.yaml", "-o", place, "--overwrite"}, {"current folder"}, path("study/inner"));
  }
}

TEST_F(Overwrite, AHomeIsLeftAlone) {
  expect_done(run(kSmall));
  const auto before = contents("out");
  const ProgramResult result =
      call({"run", "s.yaml", "-o", "out", "--overwrite"}, "", {{"HOME", path("out") + "/frames/.."}});
  EXPECT_EQ(result.status, 2) << result.err;
  EXPECT_THAT(result.err, HasSubstr("home"));
  EXPECT_EQ(contents("out"), before);
}

TEST_F(Overwrite, FoldersOfInputsAreLeftAlone) {
  expect_done(run(kSmall));
  // The resolved scenario of a run, its reamed bone, and a tool beside it.
  expect_kept("out", {"run", "out/scenario.yaml", "-o", "out", "--overwrite"}, {"input", "scenario.yaml"});
  write("s.yaml", with_bone("  source: vdb\n  vdb:\n    path: out/reamed.vdb\n"));
  expect_kept("out", {"run", "s.yaml", "-o", "out", "--overwrite"}, {"input", "reamed.vdb"});
  fs::rename(path("out"), path("a"));
  expect_done(run(with(kSmall, "depth_mm: 1", "depth_mm: 1.2")));
  fs::rename(path("out"), path("b"));
  for (const char* place : {"a", "./b/../a", "b"}) {
    expect_kept(".", {"compare", "a", "b", "-o", place, "--overwrite"}, {"input"});
  }
  fs::create_directory_symlink(path("a"), path("link"));
  expect_kept(".", {"compare", "a", "b", "-o", "link", "--overwrite"}, {"input"});
}

TEST_F(Overwrite, ALinkToAFolderStaysAndItsFolderIsReplaced) {
  expect_done(run(kSmall));
  fs::rename(path("out"), path("elsewhere"));
  fs::create_directory_symlink(path("elsewhere"), path("link"));
  const ProgramResult result =
      call({"run", "s.yaml", "-o", "link", "--overwrite", "--set", "motion.plunge.depth_mm=1.2"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_THAT(read("elsewhere/scenario.yaml"), HasSubstr("depth_mm: 1.2"));
}

TEST_F(Overwrite, ADanglingLinkIsRefusedBeforeAnyWork) {
  fs::create_directory_symlink(path("nowhere"), path("link"));
  write("s.yaml", kSmall);
  expect_kept(".", {"run", "s.yaml", "-o", "link"}, {"link", "is a link"});
  expect_kept(".", {"run", "s.yaml", "-o", "link", "--overwrite"}, {"link", "is a link"});
}

TEST_F(Overwrite, OfTwoRunsAtATimeOneIsToldToWait) {
  write("s.yaml", kSmall);
  int refused = 0;
  for (int pair = 0; pair < 8; ++pair) {
    std::array<std::future<ProgramResult>, 2> runs;
    for (auto& run : runs) {
      run = std::async(std::launch::async, [this] { return call({"run", "s.yaml", "-o", "out", "--overwrite"}); });
    }
    int done = 0;
    for (auto& run : runs) {
      const ProgramResult result = run.get();
      done += result.status == 0 ? 1 : 0;
      if (result.status == 0) continue;
      ++refused;
      EXPECT_EQ(result.status, 2) << result.err;
      EXPECT_THAT(result.err, HasSubstr("is in use by reamsim process "));
    }
    EXPECT_GE(done, 1);
    EXPECT_TRUE(exists("out/manifest.json"));
    for (const char* left : {"out.partial", "out.lock"}) EXPECT_FALSE(exists(left)) << left;
  }
  EXPECT_GT(refused, 0);
}

TEST_F(Overwrite, WhatAKilledRunLeavesBetweenTheRenamesIsNoObstacle) {
  expect_done(run(kSmall));
  fs::copy(path("out"), path("out.partial"), fs::copy_options::recursive);  // the old results, already exchanged
  write("out.lock", "reamsim process 1 on a machine since some time\n");
  for (int time = 0; time < 2; ++time) {
    expect_done(run(kSmall, {"--overwrite"}));
    EXPECT_FALSE(exists("out.partial"));
    EXPECT_FALSE(exists("out.lock"));
  }
}

TEST_F(Overwrite, AnEmptyNameIsRefused) {
  write("s.yaml", kSmall);
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"run", "s.yaml"}, {"verify", "--quick"}, {"bench", "--quick"}, {"import", "s.yaml"}}) {
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.end(), {"-o", ""});
    expect_kept(".", arguments, {"empty"});
  }
}

TEST_F(Overwrite, AnOlderFolderBesideItDoesNotMatter) {
  expect_done(run(kSmall));
  fs::create_directory(path("out.old"));
  write("out.old/thesis.tex", "years of work");
  expect_done(run(with(kSmall, "depth_mm: 1", "depth_mm: 1.2"), {"--overwrite"}));
  EXPECT_THAT(read("out/scenario.yaml"), HasSubstr("depth_mm: 1.2"));
  EXPECT_EQ(read("out.old/thesis.tex"), "years of work");
}

TEST_F(Overwrite, AnEmptyFolderIsTakenOnlyWithOverwrite) {
  fs::create_directory(path("out"));
  write("s.yaml", kSmall);
  expect_kept(".", {"run", "s.yaml", "-o", "out"}, {"exists already"});
  expect_done(run(kSmall, {"--overwrite"}));
}

TEST_F(Overwrite, FinishedResultsStayWhenSomethingTakesTheirPlace) {
  write("s.yaml", kSmall);
  const auto occupy = [this] {
    if (!exists("out.partial/forces.csv")) return false;
    fs::create_directory(path("out"));
    write("out/thesis.tex", "years of work");
    return false;
  };
  const ProgramResult result =
      reamsim({.arguments = {"run", "s.yaml", "-o", "out"}, .environment = {}, .folder = "", .interrupt_when = occupy});
  EXPECT_EQ(result.status, 1) << result.out << result.err;
  EXPECT_THAT(result.err, HasSubstr("out.partial"));
  EXPECT_EQ(read("out/thesis.tex"), "years of work");
  EXPECT_TRUE(exists("out.partial/summary.json"));
  EXPECT_TRUE(exists("out.partial/reamed.vdb"));
}

TEST_F(Overwrite, EveryFileOfARunWithEverythingIsKnown) {
  plots_ = true;
  const std::string all = with(kSmall, "render:\n  enabled: false\n",
                               "render:\n  width_px: 64\n  height_px: 64\n  film: apng\n  turntable_pictures: 2\n"
                               "  cameras: [oblique, glenoid, section, overview]\n"
                               "  user_cameras: [{name: rim-2_b, position_mm: [60, 35, 70]}]\n") +
                          "cutting: {erosion: remove}\n";
  const std::string resolved = with(all, "plunge:\n", "plunge:\n    spin_rpm: 3000\n");
  expect_done(run(with(resolved, "/assets/reamer_flat.stl\n", "/assets/reamer_convex_edges.stl\n  spin: resolved\n")));
  fs::copy(path("out/scenario.yaml"), path("out/verification.json"));  // as docs/figures.md suggests
  plots_ = false;
  expect_done(run(kSmall, {"--overwrite"}));
}

TEST_F(Overwrite, SingleFilesAreReplacedOnlyWhereReamsimWroteThem) {
  write("s.yaml", kSmall);
  write("mine.vdb", "not of reamsim");
  fs::create_directory(path("folder.vdb"));
  expect_kept(".", {"import", "s.yaml", "-o", "mine.vdb"}, {"mine.vdb", "exists already"});
  expect_kept(".", {"import", "s.yaml", "-o", "mine.vdb", "--overwrite"},
              {"mine.vdb", "not a file that reamsim wrote"});
  expect_kept(".", {"import", "s.yaml", "-o", "folder.vdb", "--overwrite"}, {"folder.vdb", "is a folder"});
  ASSERT_EQ(call({"import", "s.yaml", "-o", "ours.vdb"}).status, 0);
  EXPECT_EQ(call({"import", "s.yaml", "-o", "ours.vdb", "--overwrite"}).status, 0);
  write("v.yaml", with_bone("  source: vdb\n  vdb:\n    path: ours.vdb\n"));
  expect_kept(".", {"import", "v.yaml", "-o", "./ours.vdb", "--overwrite"}, {"ours.vdb", "is an input"});
  write("thesis.md", "years of work");
  expect_kept(".", {"bench", "--quick", "--json", "thesis.md", "-o", "b"}, {"thesis.md", "exists already"});
  expect_kept(".", {"bench", "--quick", "--json", "thesis.md", "-o", "b", "--overwrite"}, {"thesis.md", "--json"});
}

TEST_F(Overwrite, ClosedStandardOutputLeavesTheResultsAsTheyAre) {
  expect_done(run(kSmall));
  const std::string forces = read("out/forces.csv");
  const ProgramResult result = reamsim({.arguments = {"run", "s.yaml", "-o", "closed"},
                                        .environment = {},
                                        .folder = "",
                                        .interrupt_when = {},
                                        .closed_output = true});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(read("closed/forces.csv"), forces);
}

TEST_F(Overwrite, AWorkGroupTooLargeForTheDeviceIsRefused) {
  const std::string on_opencl = with(kSmall, "device: serial", "device: auto");
  write("s.yaml", on_opencl);
  const auto run_with = [this](const char* tuning) {
    return reamsim({.arguments = {"run", "s.yaml", "-o", "out"},
                    .environment = {{"REAMSIM_ENGINE_TUNING", tuning}},
                    .folder = "",
                    .interrupt_when = {}});
  };
  expect_refused(run_with("culling=true work_group_size=40960"), 2,
                 {"REAMSIM_ENGINE_TUNING", "found work_group_size=40960", "expected at most"});
  expect_refused(run_with("kernel_shape=fpga"), 2,
                 {"REAMSIM_ENGINE_TUNING", "found kernel_shape=fpga", "auto|cpu|gpu"});
}

TEST_F(Overwrite, VoxelsLargerThanTheBoneAreDrawn) {
  const std::string drawn = with(kSmall, "enabled: false", "width_px: 96\n  height_px: 72");
  for (const std::string erosion : {"exact", "remove"}) {
    const ProgramResult result = run(drawn, {"--set", "bone.voxel_mm=5", "--set", "cutting.erosion=" + erosion});
    EXPECT_EQ(result.signal, 0);
    expect_done(result);
    fs::remove_all(path("out"));
  }
}

}  // namespace
}  // namespace reamsim::test
