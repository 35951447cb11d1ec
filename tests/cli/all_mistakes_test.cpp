// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// `check` and `run` say every mistake that they can find, each in one line.
#include <sstream>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::ElementsAre;
using ::testing::StartsWith;

class AllMistakes : public CliTest {
 protected:
  std::vector<std::string> lines_of(const std::string& command, const std::string& yaml) const {
    write("s.yaml", yaml);
    const ProgramResult result =
        reamsim({.arguments = {command, "s.yaml"}, .environment = {}, .folder = "", .interrupt_when = {}});
    EXPECT_EQ(result.status, 2) << result.out;
    std::vector<std::string> lines;
    std::istringstream in(result.err);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  }
};

TEST_F(AllMistakes, OfSeveralKindsInTheOrderOfTheFile) {
  const std::string yaml =
      with(with(with(with(kSmall, "voxel_mm: 0.5", "voxel_mm: 9"), "/assets/reamer_flat.stl", "/assets/nix.stl"),
                "feed_mm_s: 5", "feed_mm_min: 5"),
           "dwell_s: 0", "dwell_s: long") +
      "cutting: {specific_energy_table: [{density_g_cm3: 1, energy_j_mm3: 0.1}]}\n"
      "metrics: {implant: {backside_radius_mm: 20, diameter_mm: 41}}\n";
  const std::string at = "reamsim: error: s.yaml:";
  for (const char* command : {"check", "run"}) {
    EXPECT_THAT(
        lines_of(command, yaml),
        ElementsAre(StartsWith(at + "4:13: bone.voxel_mm: found 9"), StartsWith(at + "9:9: tool.mesh: no such file"),
                    StartsWith(at + "14:5: motion.plunge.feed_mm_min: unknown key; did you mean feed_mm_s"),
                    StartsWith(at + "16:14: motion.plunge.dwell_s: found the text \"long\""),
                    StartsWith(at + "23:11: cutting.specific_energy_table: found a list of 1"),
                    StartsWith(at + "24:45: metrics.implant.diameter_mm: found 41")));
  }
}

TEST_F(AllMistakes, OfEveryItemOfAList) {
  const std::string yaml =
      kSmall + "render:\n  user_cameras:\n    - {name: A, position_mm: [0, 0]}\n    - 3\n    - {name: b}\n";
  const std::string cameras = with(yaml, "render:\n  enabled: false\n", "");
  EXPECT_THAT(lines_of("check", cameras),
              ElementsAre(StartsWith("reamsim: error: s.yaml:23:30: render.user_cameras.0.position_mm: found a list"),
                          StartsWith("reamsim: error: s.yaml:24:7: render.user_cameras.1: found 3"),
                          StartsWith("reamsim: error: s.yaml:25:7: render.user_cameras.2.position_mm: missing")));
}

TEST_F(AllMistakes, WhatFollowsFromAMistakeIsNotOne) {
  const auto only = [&](const std::string& from, const std::string& to, const std::string& start) {
    EXPECT_THAT(lines_of("check", with(kSmall, from, to)), ElementsAre(StartsWith("reamsim: error: s.yaml:" + start)));
  };
  only("source: phantom", "sorce: phantom", "3:3: bone.sorce: unknown key; did you mean source");
  only("source: phantom", "source: photo", "3:11: bone.source: found the text \"photo\"");
  only("bone:\n", "bones:\n", "2:1: bones: unknown key; did you mean bone");
  only("  plunge:\n", "  plunger:\n", "12:3: motion.plunger: unknown key; did you mean plunge");
  only("tool:\n  mesh: ", "tool: ", "8:");
}

TEST_F(AllMistakes, OfAllOverrides) {
  write("s.yaml", kSmall);
  const ProgramResult result = reamsim({.arguments = {"check", "s.yaml", "--set", "bone", "--set", "=3"},
                                        .environment = {},
                                        .folder = "",
                                        .interrupt_when = {}});
  EXPECT_EQ(result.status, 2);
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 2) << result.err;
}

TEST_F(AllMistakes, NoMoreThanAnyoneReads) {
  std::string many;
  for (int i = 0; i < 500; ++i) many += "zz" + std::to_string(i) + ": 1\n";
  const std::vector<std::string> lines = lines_of("check", kSmall + many);
  ASSERT_EQ(lines.size(), 51u);
  EXPECT_EQ(lines.back(), "reamsim: error: and 450 mistakes more");
}

}  // namespace
}  // namespace reamsim::test
