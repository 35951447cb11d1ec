// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Several plunges with tools of their own, one after another on the same bone.
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

constexpr double kRadius_mm = 14;  // of the hemispherical reamer
constexpr double kBore_mm = 1.25;  // of its cannula

/// kSmall with other motions; `lines` are items of motion.passes.
std::string with_passes(const std::string& lines) {
  const std::size_t from = kSmall.find("  plunge:\n"), to = kSmall.find("render:\n");
  return kSmall.substr(0, from) + "  passes:\n" + lines + kSmall.substr(to);
}

/// An item of motion.passes: a hemispherical reamer of this scale.
std::string pass(double scale, double depth_mm) {
  std::ostringstream out;
  out << "  - tool: {mesh: " REAMSIM_ROOT "/assets/reamer_hemispherical.stl, scale: " << scale << "}\n"
      << "    plunge: {approach_mm: 0.5, feed_mm_s: 2, depth_mm: " << depth_mm
      << ", dwell_s: 0.1, retract_mm: 4, retract_mm_s: 20}\n";
  return out.str();
}

/// Spherical cap without the core in the cannula.
double cut_mm3(double scale, double depth_mm) {
  const double r = kRadius_mm * scale, bore = kBore_mm * scale;
  const double cap = M_PI * depth_mm * depth_mm * (r - depth_mm / 3);
  const double sag = r - std::sqrt(r * r - bore * bore);
  return cap - M_PI * bore * bore * (depth_mm - sag / 2);
}

class Passes : public CliTest {
 protected:
  nlohmann::json summary() const { return nlohmann::json::parse(read("out/summary.json")); }

  /// A column of forces.csv.
  std::vector<double> column(const std::string& name) const {
    std::istringstream log(read("out/forces.csv"));
    std::string line, cell;
    std::getline(log, line);
    std::istringstream head(line);
    int at = 0;
    while (std::getline(head, cell, ',') && cell != name) ++at;
    std::vector<double> out;
    while (std::getline(log, line)) {
      std::istringstream row(line);
      for (int i = 0; i <= at; ++i) std::getline(row, cell, ',');
      out.push_back(std::stod(cell));
    }
    return out;
  }
};

const std::string kFine = "voxel_mm: 0.1";

TEST_F(Passes, EachCutsWhatTheOnesBeforeHaveLeft) {
  // The larger cap contains the smaller one but for the core under the smaller cannula, which it cuts as well.
  const std::string yaml = with(with_passes(pass(0.5, 1) + pass(0.6, 1) + pass(0.7, 0.5)), "voxel_mm: 0.5", kFine);
  expect_done(run(yaml));
  const auto passes = summary()["passes"];
  ASSERT_EQ(passes.size(), 3);
  const double first = cut_mm3(0.5, 1), both = cut_mm3(0.6, 1);
  // The second cannula is wider: its core keeps a ring less that the first pass has cut already.
  const double ring = [] {
    const double inner = 0.5 * kBore_mm, outer = 0.6 * kBore_mm, r = 0.5 * kRadius_mm;
    const auto cap_to = [&](double a) {
      const double sag = r - std::sqrt(r * r - a * a);
      return M_PI * a * a * (1 - sag / 2);
    };
    return cap_to(outer) - cap_to(inner);
  }();
  EXPECT_NEAR(passes[0]["removed_mm3"].get<double>(), first, 0.002 * first);
  EXPECT_NEAR(passes[1]["removed_mm3"].get<double>(), both + ring - first, 0.005 * both);
  EXPECT_EQ(passes[2]["removed_mm3"], 0) << "it does not reach the bone that is left";
  EXPECT_EQ(passes[2]["first_contact_frame"], -1);
  EXPECT_NEAR(summary()["removed_mm3"].get<double>(), both + ring, 0.002 * both);
  EXPECT_THAT(summary()["warnings"].dump(), HasSubstr("pass 3: the tool never touches the bone"));
}

TEST_F(Passes, FramesFollowOneAnotherAndDepthBeginsAnew) {
  expect_done(run(with_passes(pass(0.5, 1) + pass(0.7, 2))));
  const auto frame = column("frame"), number = column("pass"), depth = column("depth_mm");
  std::size_t change = 0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    EXPECT_EQ(frame[i], i);
    if (i > 0 && number[i] != number[i - 1]) change = i;
  }
  EXPECT_EQ(number.front(), 1);
  EXPECT_EQ(number.back(), 2);
  EXPECT_EQ(depth[change], 0);
  const auto passes = summary()["passes"];
  EXPECT_EQ(passes[0]["last_frame"], change - 1);
  EXPECT_EQ(passes[1]["first_frame"], change);
  EXPECT_NEAR(passes[0]["max_depth_mm"].get<double>(), 1, 0.03);
  EXPECT_GT(passes[1]["max_depth_mm"].get<double>(), 0.9) << "from where it meets the cup that the first pass cut";
}

TEST_F(Passes, OneIsAPlunge) {
  const std::size_t from = kSmall.find("    approach_mm"), to = kSmall.find("render:\n");
  std::string keys = kSmall.substr(from, to - from);
  for (std::size_t at = 0; (at = keys.find("    ", at)) != std::string::npos; at += 8) keys.insert(at, "    ");
  expect_done(run(kSmall));
  const std::string plunge = read("out/forces.csv");
  expect_done(run(with_passes("  - plunge:\n" + keys), {"--overwrite"}));
  EXPECT_EQ(read("out/forces.csv"), plunge);
}

TEST_F(Passes, TheSameBytesOnEveryDeviceAndForEveryBatch) {
  const std::string serial = with_passes(pass(0.5, 1) + pass(0.7, 1.5));
  expect_done(run(serial));
  const std::string log = read("out/forces.csv");
  for (const char* engine : {"  batch_frames: 1\n", "  batch_frames: 1000\n"}) {
    expect_done(run(with(serial, "  device: serial\n", engine), {"--overwrite"}));
    EXPECT_EQ(read("out/forces.csv"), log) << engine;
  }
}

TEST_F(Passes, APictureShowsTheToolOfItsFrame) {
  const std::string drawn =
      with(with_passes(pass(0.4, 0.5) + pass(0.9, 0.5)), "  enabled: false\n",
           "  every_frames: 40\n  width_px: 96\n  height_px: 72\n  tool_look: steel\n  report: false\n");
  expect_done(run(drawn));
  EXPECT_TRUE(exists("out/snapshots/tool_2.stl"));
  const std::string first = read("out/frames/000040.png"), last = read("out/reamed.png");
  ASSERT_EQ(reamsim({.arguments = {"render", "out"}, .environment = {}, .folder = "", .interrupt_when = {}}).status, 0);
  EXPECT_TRUE(read("out/frames/000040.png") == first);
  EXPECT_TRUE(read("out/reamed.png") == last);
}

TEST_F(Passes, MistakesAreNamedAtTheirKeys) {
  const auto refused = [this](const std::string& yaml, const std::string& message) {
    const ProgramResult result = run(yaml);
    EXPECT_EQ(result.status, 2);
    EXPECT_THAT(result.err, HasSubstr(message));
  };
  refused(with_passes("  - tool: {mesh: missing.stl}\n    plunge: {}\n"), "motion.passes.0.tool.mesh: no such file");
  refused(with_passes("  - plunge: {depth_mm: -1}\n"), "motion.passes.0.plunge.depth_mm");
  refused(with_passes("  - plunge: {approach_mm: 0, depth_mm: 0}\n"), "motion.passes.0.plunge.approach_mm");
  refused(with(kSmall, "  plunge:\n", "  passes:\n  - plunge: {}\n  plunge:\n"), "motion");
  refused(with_passes("  []\n"), "motion");
  refused(with(with_passes("  - plunge: {}\n  - plunge: {}\n    tool: {mesh: " REAMSIM_ROOT
                           "/assets/reamer_convex_edges.stl, spin: resolved}\n"),
               "engine:\n", "cutting: {edge_force: {tangential_n_mm: 1, normal_n_mm: 0, cutting_edges: 6}}\nengine:\n"),
          "motion.passes.1.tool.spin: found resolved; expected envelope");
}

}  // namespace
}  // namespace reamsim::test
