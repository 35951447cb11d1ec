// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// One force, one torque and one depth: what a run prints of them, wherever it does.
#include <nlohmann/json.hpp>

#include "render/pictures/run_view.h"
#include "sim/base/text.h"
#include "sim/record/force_log.h"
#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Pair;

std::string with_erosion(const std::string& erosion) {
  return with(kSmall, "  enabled: false\n",
              "  enabled: true\n  width_px: 96\n  height_px: 72\n  every_frames: 40\n"
              "  cameras: [oblique]\n  before_after: false\n  contact_sheet: false\n") +
         "cutting:\n  erosion: " + erosion + "\n";
}

class HeadlineTest : public CliTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(HeadlineTest, IsTheSameEverywhere) {
  plots_ = true;
  const std::string erosion = GetParam();
  const bool means = erosion != "exact";
  const ProgramResult result = run(with_erosion(erosion));
  expect_done(result);
  const auto summary = nlohmann::json::parse(read("out/summary.json"));
  const auto& headline = summary["headline"];
  const std::string force = fixed_text(headline["peak_axial_force_n"].get<double>(), 1);
  const std::string torque = fixed_text(headline["peak_spin_torque_nmm"].get<double>(), 0);
  const std::string depth = fixed_text(headline["depth_mm"].get<double>(), 2);
  const std::string force_name = headline["force_name"];
  const std::string depth_name = headline["depth_name"];
  ASSERT_GT(headline["peak_axial_force_n"].get<double>(), 1);
  EXPECT_NEAR(headline["depth_mm"].get<double>(), 1, 0.5);
  EXPECT_EQ(force_name, means ? "peak mean axial force" : "peak axial force");
  EXPECT_THAT(headline["force_definition"].get<std::string>(), HasSubstr(means ? "one voxel" : "single frame"));

  // The numbers that had their places before keep them, and agree.
  const auto& forces = summary["forces"];
  EXPECT_EQ(headline["peak_axial_force_n"], forces[means ? "peak_layer_axial_force_n" : "peak_axial_force_n"]);
  EXPECT_EQ(headline["depth_mm"], summary["max_depth_mm"]);
  // Another number would be another text, or this test could not tell them apart.
  EXPECT_TRUE(!means || force != fixed_text(forces["peak_axial_force_n"].get<double>(), 1));

  // The closing line.
  EXPECT_THAT(result.out, HasSubstr(depth_name + " " + depth + " mm; " + force_name + " " + force + " N, "));
  EXPECT_THAT(result.out, HasSubstr(" " + torque + " N mm; "));

  // The pictures.
  const ForceLog log = read_force_log(path("out/forces.csv"), {.mean_travel_mm = means ? 0.5 : 0});
  const Captions captions(log, true);
  const Captions::Values shown = captions.after(0.123);
  EXPECT_THAT(shown, AllOf(Contains(Pair(depth_name, depth + " mm")), Contains(Pair(force_name, force + " N")),
                           Contains(Pair("greatest reamed depth", "0.12 mm"))));
  for (const auto& [name, value] : shown) {
    EXPECT_EQ(value == force + " N", name == force_name) << name;
  }
  for (const ForceRow& row : log.rows) {
    if (const auto arrow = captions.arrow(row)) {
      EXPECT_THAT(arrow->text, ::testing::StartsWith(means ? "mean axial force " : "resultant "));
    }
  }

  // The plots, as scripts and as what is drawn.
  for (const char* plot : {"forces", "plots/forces_depth"}) {
    const std::string script = read(std::string("out/") + plot + ".gp");
    EXPECT_THAT(script, HasSubstr("headline_force = '" + force_name + " " + force + " N'")) << plot;
    EXPECT_THAT(script, HasSubstr("headline_depth = '" + depth_name + " " + depth + " mm'")) << plot;
    const std::string drawn = read(std::string("out/") + plot + ".svg");
    for (const std::string& text : {force_name + " " + force + " N", depth_name + " " + depth + " mm", torque}) {
      EXPECT_THAT(drawn, HasSubstr(text)) << plot;
    }
  }

  // The report.
  const std::string report = read("out/report.html");
  EXPECT_THAT(report, HasSubstr("[\"" + force_name + "\",\"" + force + "\",\"N\"]"));
  EXPECT_THAT(report, HasSubstr("[\"" + depth_name + "\",\"" + depth + "\",\"mm\"]"));
}

using HeadlineOfARun = CliTest;

TEST_F(HeadlineOfARun, TorqueDoesNotDependOnTheSenseOfTheSpin) {
  const auto headline = [&](const std::string& spin_rpm) {
    expect_done(run(with(kSmall, "    depth_mm: 1\n", "    depth_mm: 1\n    spin_rpm: " + spin_rpm + "\n")));
    std::filesystem::remove_all(path("before"));
    std::filesystem::rename(path("out"), path("before"));
    return nlohmann::json::parse(read("before/summary.json"))["headline"];
  };
  const auto clockwise = headline("200");
  EXPECT_GT(clockwise["peak_spin_torque_nmm"].get<double>(), 10);
  EXPECT_EQ(headline("-200"), clockwise);
}

INSTANTIATE_TEST_SUITE_P(Erosion, HeadlineTest, ::testing::Values("exact", "remove"));

}  // namespace
}  // namespace reamsim::test
