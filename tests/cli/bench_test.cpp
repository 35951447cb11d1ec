// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

class BenchCommand : public CliTest {
 protected:
  ProgramResult bench(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"bench", "--quick", "-o", "out"});
    return reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
  }
};

TEST_F(BenchCommand, UnwritableJson) {
  expect_refused(bench({"--json", "no-such-folder/bench.json"}), 2, {"no-such-folder/bench.json", "--json"});
}

TEST_F(BenchCommand, UnknownEngine) {
  expect_refused(bench({"--engines", "direct,sparse"}), 2, {"--engines", "sparse", "bricked", "implicit"});
}

TEST_F(BenchCommand, UnknownDevice) {
  expect_refused(bench({"--device", "nonexistent"}), 2, {"nonexistent"});
}

TEST_F(BenchCommand, FolderThatCannotBeMade) {
  write("file", "not a folder");
  const ProgramResult result = reamsim(
      {.arguments = {"bench", "--quick", "-o", "file/out"}, .environment = {}, .folder = "", .interrupt_when = {}});
  expect_refused(result, 2, {"file/out", "output folder"});
}

TEST_F(BenchCommand, LatencyIsThatOfFramesInContact) {
  write("s.yaml", with(kSmall, "frame_rate_hz: 100\n", "frame_rate_hz: 500\n"));
  write("away.yaml", with(kSmall, "  plunge:\n", "  plunge:\n    entry_mm: [90, 0, 0]\n"));
  const auto latency = [&](const char* scenario) {
    return reamsim(
        {.arguments = {"bench", "--latency", scenario}, .environment = {}, .folder = "", .interrupt_when = {}});
  };
  const ProgramResult result = latency("s.yaml");
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out,
              ::testing::ContainsRegex("[1-9][0-9]* frames in contact, median [0-9.]+ ms, 99 % [0-9.]+ ms"));
  expect_refused(latency("away.yaml"), 2, {"away.yaml", "motion", "no more than 20 frames are in contact"});
}

TEST_F(BenchCommand, LatencyWritesNoFileAndSaysSo) {
  for (const std::vector<std::string>& option :
       {std::vector<std::string>{"--json", "latency.json"}, {"-o", "out"}, {"--overwrite"}, {"--engines", "exact"}}) {
    std::vector<std::string> arguments{"bench", "--latency", "default"};
    arguments.insert(arguments.end(), option.begin(), option.end());
    const ProgramResult result =
        reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
    expect_refused(result, 2, {"--latency"});
  }
}

}  // namespace
}  // namespace reamsim::test
