// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// motion.push from the command line: columns, events, interruption, mistakes.
#include <csignal>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// kSmall with a push; `more` are lines of motion.push.
std::string pushed(const std::string& more) {
  const std::size_t from = kSmall.find("  plunge:\n"), to = kSmall.find("render:\n");
  return kSmall.substr(0, from) + "  push:\n    approach_mm: 0.5\n    thrust_n: 60\n" + more + kSmall.substr(to);
}

const std::string kToDepth = pushed("    depth_mm: 0.5\n");

class PushCommand : public CliTest {
 protected:
  nlohmann::json summary() const { return nlohmann::json::parse(read("out/summary.json")); }

  /// Rows of a CSV by column name.
  std::vector<std::map<std::string, std::string>> table(const std::string& file) const {
    std::istringstream in(read(file));
    std::string line, cell;
    std::getline(in, line);
    std::vector<std::string> names;
    for (std::istringstream head(line); std::getline(head, cell, ',');) names.push_back(cell);
    std::vector<std::map<std::string, std::string>> out;
    while (std::getline(in, line)) {
      auto& row = out.emplace_back();
      std::size_t i = 0;
      for (std::istringstream cells(line); std::getline(cells, cell, ',');) row[names.at(i++)] = cell;
    }
    return out;
  }
};

TEST_F(PushCommand, BoneHoldsTheThrustAndColumnsAndSummarySaySo) {
  expect_done(run(kToDepth));
  const auto rows = table("out/forces.csv");
  ASSERT_GT(rows.size(), 50U);
  const auto at = [&](std::size_t k, const char* name) { return std::stod(rows[k].at(name)); };
  EXPECT_EQ(at(5, "feed_mm_s"), 5) << "in air";
  EXPECT_EQ(at(5, "hand_force_n"), 0);
  const std::size_t last = rows.size() - 1;
  EXPECT_NEAR(at(last, "axial_force_n"), 60, 0.6);
  EXPECT_EQ(at(last, "hand_force_n"), 60);
  EXPECT_NEAR(at(last, "hand_power_w"), 60e-3 * at(last, "feed_mm_s"), 1e-12);
  EXPECT_NEAR(at(last, "drill_power_w"), 1e-3 * at(last, "spin_torque_nmm") * 250 * 2 * M_PI / 60, 1e-9);
  EXPECT_GE(at(last, "depth_mm"), 0.5 - 0.05 - 1e-9);
  const auto events = table("out/events.csv");
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].at("event"), "contact");
  EXPECT_EQ(events[1].at("event"), "end");
  EXPECT_EQ(summary()["push"]["events"].size(), 2U);
  EXPECT_EQ(summary()["push"]["drill_work_mj"], summary()["push"]["spindle_work_mj"]) << "its name in 1.0";
  EXPECT_NEAR(summary()["push"]["spindle_work_mj"].get<double>() + summary()["push"]["hand_work_mj"].get<double>() +
                  summary()["floor_energy_mj"].get<double>(),
              summary()["energy_mj"].get<double>(), 2e-3 * summary()["energy_mj"].get<double>());
}

TEST_F(PushCommand, BreaksThroughTheFarSideAndTheOvershootIsTheLimitOfTheFeed) {
  // A plate: beyond it is air.
  const std::string yaml =
      with(pushed("    until: time\n    time_s: 6\n"), "    size_mm: [10, 10, 6]\n", "    size_mm: [10, 10, 1.5]\n");
  expect_done(run(yaml));
  const auto push = summary()["push"];
  EXPECT_NEAR(push["overshoot_mm"].get<double>(), 5 * 0.2, 0.06);
  std::vector<std::string> names;
  for (const auto& event : push["events"]) names.push_back(event["event"]);
  EXPECT_EQ(names, (std::vector<std::string>{"contact", "breakthrough", "end"}));
}

TEST_F(PushCommand, StallEndsAndIsListed) {
  const std::string yaml = pushed("    until: stall\n") +
                           "cutting: {edge_force: {tangential_n_mm: 0.1, normal_n_mm: 30, cutting_edges: 1}}\n";
  expect_done(run(yaml));
  const auto events = table("out/events.csv");
  ASSERT_EQ(events.size(), 3U);
  EXPECT_EQ(events[1].at("event"), "stall");
  EXPECT_EQ(std::stod(events[1].at("value")), 60);
}

TEST_F(PushCommand, AnEdgeForceWithoutRemovalIsContact) {
  const std::string yaml = pushed("    until: stall\n") +
                           "cutting: {edge_force: {tangential_n_mm: 1, normal_n_mm: 1000, cutting_edges: 6}}\n";
  const ProgramResult result = run(yaml);
  expect_done(result);
  EXPECT_EQ(summary()["removed_mm3"], 0);
  const auto rows = table("out/forces.csv"), events = table("out/events.csv");
  std::size_t touching = 0;
  for (const auto& row : rows) touching += std::stod(row.at("axial_force_n")) > 0 ? 1 : 0;
  EXPECT_GT(touching, 5U);
  ASSERT_GE(events.size(), 2U);
  EXPECT_EQ(events[0].at("event"), "contact");
  EXPECT_EQ(events[1].at("event"), "stall");
  EXPECT_EQ(summary()["contact_frames"], touching);
  EXPECT_EQ(std::to_string(summary()["first_contact_frame"].get<int>()), events[0].at("frame"));
  EXPECT_THAT(result.err, Not(HasSubstr("never touches")));
}

TEST_F(PushCommand, ProfileSetsTheThrust) {
  write("thrust.csv", "time_s,thrust_n\n0,20\n1,20\n2,80\n");
  const std::string yaml =
      with(pushed("    profile: thrust.csv\n    until: time\n    time_s: 3\n"), "    thrust_n: 60\n", "");
  expect_done(run(yaml));
  const auto rows = table("out/forces.csv");
  const auto thrust = [&](std::size_t k) { return std::stod(rows[k].at("thrust_n")); };
  EXPECT_EQ(rows.size(), 301U);
  EXPECT_EQ(thrust(50), 20);
  EXPECT_NEAR(thrust(150), 50 - 0.3, 1e-9) << "in the middle of the frame";
  EXPECT_EQ(thrust(300), 80);
  EXPECT_NEAR(std::stod(rows[300].at("axial_force_n")), 80, 1);
  write("thrust.csv", "time_s,thrust_n\n0,20\n0,30\n");
  std::filesystem::remove_all(path("out"));
  expect_refused(run(yaml), 2, {"thrust.csv:3", "time_s", "later"});
  write("thrust.csv", "time_s;thrust_n\n0;20\n1;30\n");
  expect_refused(run(yaml), 2, {"thrust.csv:1: semicolons separate the columns; save it with commas"});
  write("thrust.csv", "time_s,thrust_n\n0;20\n1;30\n");
  expect_refused(run(yaml), 2, {"thrust.csv:2: semicolons separate the columns"});
}

TEST_F(PushCommand, ContinuesWithTheSameBytes) {
  const std::string yaml = with(
      with(pushed("    until: time\n    time_s: 3\n"), "  enabled: false\n", "  enabled: false\n  every_frames: 999\n"),
      "engine:\n  device: serial\n", "output:\n  checkpoint_s: 1\nengine:\n  batch_frames: 8\n");
  expect_done(run(yaml));
  const std::string forces = read("out/forces.csv"), events = read("out/events.csv"), vdb = read("out/reamed.vdb");
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
  call.interrupt_signal = SIGINT;
  ProgramResult cut = reamsim(call);
  // On a busy machine the signal may come after the last frame.
  for (int again = 0; again < 3 && cut.status == 0; ++again) {
    std::filesystem::remove_all(path("out"));
    cut = reamsim(call);
  }
  EXPECT_EQ(cut.status, 75) << cut.err;
  const ProgramResult render =
      reamsim({.arguments = {"render", "out.partial", "--only", "pictures", "--width", "96", "--height", "72"},
               .environment = {},
               .folder = "",
               .interrupt_when = {}});
  EXPECT_EQ(render.status, 0) << render.err;
  EXPECT_TRUE(exists("out.partial/frames/000000.png"));
  expect_done(run(yaml, {"--resume"}));
  EXPECT_EQ(read("out/forces.csv"), forces);
  EXPECT_EQ(read("out/events.csv"), events);
  EXPECT_EQ(read("out/reamed.vdb"), vdb);
}

TEST_F(PushCommand, WhatCannotBePushedIsRefusedAtItsKey) {
  expect_refused(run(kToDepth + "cutting: {erosion: remove}\n"), 2, {"cutting.erosion", "motion.push"});
  expect_refused(run(with(kToDepth, "reamer_flat.stl\n", "reamer_flat.stl\n  spin: resolved\n")), 2, {"tool.spin"});
  expect_refused(run(pushed("    max_feed_mm_s: 40\n")), 2, {"motion.push.max_feed_mm_s", "found 40", "at most 25"});
  expect_refused(run(with(kToDepth, "thrust_n: 60", "thrust_n: 0")), 2, {"motion.push.thrust_n"});
  expect_refused(run(pushed("    mass_kg: -1\n")), 2, {"motion.push.mass_kg"});
  expect_refused(run(kToDepth + "output: {force_basis: true}\n"), 2, {"output.force_basis"});
  const std::string away = with(kToDepth, "    approach_mm: 0.5\n", "    from: contact\n    entry_mm: [90, 0, 0]\n");
  expect_refused(run(away), 2, {"motion.push.entry_mm", "meets no bone on the line of the push"});
}

TEST_F(PushCommand, EndingByTimeBeforeTheDepthIsWarnedOf) {
  const ProgramResult result = run(pushed("    time_s: 0.3\n"));
  expect_done(result);
  EXPECT_THAT(result.err, HasSubstr("motion.push ended after time_s without reaching depth_mm"));
}

TEST_F(PushCommand, CheckSaysWhatIsNotKnown) {
  write("s.yaml", kToDepth);
  const ProgramResult result =
      reamsim({.arguments = {"check", "s.yaml"}, .environment = {}, .folder = "", .interrupt_when = {}});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("its feed is known only when it is run"));
  EXPECT_THAT(result.out, HasSubstr("time: not estimated"));
}

}  // namespace
}  // namespace reamsim::test
