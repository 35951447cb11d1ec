// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// motion.compliance from the command line: columns, summary, plot, interruption, passes, mistakes.
#include <csignal>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

/// kSmall on springs; `more` are lines of motion.compliance.
std::string sprung(const std::string& more, const std::string& yaml = kSmall) {
  return with(yaml, "render:\n", "  compliance:\n" + more + "render:\n");
}

const std::string kSprings = "    stiffness_n_mm: [40, 40, 80]\n    damping_n_s_mm: 1\n";

class ComplianceCommand : public CliTest {
 protected:
  nlohmann::json summary() const { return nlohmann::json::parse(read("out/summary.json")); }
  std::string header() const {
    const std::string forces = read("out/forces.csv");
    return forces.substr(0, forces.find('\n'));
  }
};

TEST_F(ComplianceCommand, ColumnsFollowTheOthersOnlyWhereSpringsAre) {
  expect_done(run(kSmall));
  EXPECT_TRUE(header().ends_with(",balance,pass")) << header();
  EXPECT_FALSE(summary().contains("deflection"));
  std::filesystem::remove_all(path("out"));
  expect_done(run(sprung(kSprings)));
  EXPECT_TRUE(header().ends_with(",pass,deflection_x_mm,deflection_y_mm,deflection_z_mm")) << header();
  const auto deflection = summary()["deflection"];
  EXPECT_GT(deflection["peak_mm"].get<double>(), 0.02);
  EXPECT_GE(deflection["peak_mm"].get<double>(), deflection["peak_lateral_mm"].get<double>());
  // The last row: z of the tool is the plan's and the deflection.
  std::istringstream in(read("out/forces.csv"));
  std::string line, cell;
  double peak = 0;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::vector<double> values;
    for (std::istringstream cells(line); std::getline(cells, cell, ',');) values.push_back(std::stod(cell));
    ASSERT_EQ(values.size(), 29U);
    peak = std::max(peak, std::hypot(values[26], values[27], values[28]));
  }
  EXPECT_NEAR(peak, deflection["peak_mm"].get<double>(), 1e-12);
}

TEST_F(ComplianceCommand, PlotOfTheDeflectionIsMade) {
  plots_ = true;
  const std::string yaml =
      with(sprung(kSprings), "  enabled: false\n", "  width_px: 64\n  height_px: 64\n  report: false\n");
  expect_done(run(yaml));
  EXPECT_TRUE(exists("out/plots/deflection.png"));
  EXPECT_TRUE(exists("out/plots/deflection.pdf"));
}

TEST_F(ComplianceCommand, ContinuesWithTheSameBytes) {
  const std::string fast = with(sprung(kSprings), "engine:\n  device: serial\n", "output:\n  checkpoint_s: 0.02\n");
  const std::string unseen = with(fast, "  enabled: false\n", "  enabled: false\n  every_frames: 9999\n");
  const std::string yaml = with(unseen, "feed_mm_s: 5", "feed_mm_s: 1");  // some seconds, so that it can be interrupted
  const std::vector<std::string> rate{"--set", "motion.frame_rate_hz=500"};
  expect_done(run(yaml, rate));
  const std::string forces = read("out/forces.csv"), vdb = read("out/reamed.vdb");
  std::filesystem::remove_all(path("out"));
  const auto is_underway = [&] {
    std::error_code none_yet;
    const auto bytes = std::filesystem::file_size(path("out.partial/forces.csv"), none_yet);
    return !none_yet && bytes > forces.size() / 8;
  };
  ProgramCall call{.arguments = {"run", "s.yaml", "-o", "out", "--quiet"},
                   .environment = {},
                   .folder = "",
                   .interrupt_when = is_underway};
  call.arguments.insert(call.arguments.end(), rate.begin(), rate.end());
  call.interrupt_signal = SIGINT;
  const ProgramResult cut = reamsim(call);
  EXPECT_EQ(cut.status, 75) << cut.err;
  expect_done(run(yaml, {"--resume", "--set", "motion.frame_rate_hz=500"}));
  EXPECT_EQ(read("out/forces.csv"), forces);
  EXPECT_EQ(read("out/reamed.vdb"), vdb);
}

TEST_F(ComplianceCommand, WhatCannotGiveWayIsRefusedAtItsKey) {
  const std::string springs = sprung(kSprings);
  expect_refused(run(springs + "cutting: {erosion: remove}\n"), 2, {"cutting.erosion", "motion.compliance"});
  expect_refused(run(springs + "output: {force_basis: true}\n"), 2, {"output.force_basis", "motion.compliance"});
  expect_refused(run(sprung("    stiffness_n_mm: [1e6, 1e6, 1e6]\n")), 2,
                 {"motion.compliance.stiffness_n_mm", "rigid", "in all directions"});
  expect_refused(run(sprung("    stiffness_n_mm: [0, 40, 40]\n")), 2, {"motion.compliance.stiffness_n_mm"});
  expect_refused(run(sprung("    damping_n_s_mm: 1\n")), 2, {"motion.compliance.stiffness_n_mm"});
  expect_refused(run(sprung(kSprings + "    mass_kg: 1\n")), 2, {"motion.compliance.mass_kg"});
  const std::size_t from = kSmall.find("  plunge:\n"), to = kSmall.find("render:\n");
  const std::string pushed = kSmall.substr(0, from) + "  push: {thrust_n: 60}\n" + kSmall.substr(to);
  expect_refused(run(sprung(kSprings, pushed)), 2, {"motion.compliance", "motion.push", "one of both"});
}

TEST_F(ComplianceCommand, CheckShowsTheSprings) {
  write("s.yaml", sprung("    stiffness_n_mm: [40, 1e6, 80]\n"));
  const ProgramResult result =
      reamsim({.arguments = {"check", "s.yaml"}, .environment = {}, .folder = "", .interrupt_when = {}});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("compliance: 40, 1e+06 and 80 N/mm along x, y and z of the tool (1e+06: rigid)"));
}

}  // namespace
}  // namespace reamsim::test
