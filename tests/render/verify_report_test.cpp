// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/plots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "sim/base/error.h"
#include "tests/render/picture_file.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using verify::Measure;

verify::Findings some_findings() {
  verify::CaseFindings found;
  found.id = "cap";
  found.title = "A cap";
  found.scene = "a ball in a block";
  found.form = "π·d²·(R − d/3)";
  verify::Refinement refinement{"removed volume", "mm³", "voxel, mm", 100, {}, 2.0, {0.001, 1.25, 2.1}};
  for (const double step : {1.0, 0.5, 0.25, 0.125})
    refinement.levels.push_back({step, 100 + step * step, step * step / 100, 1});
  verify::Refinement free{"mean force", "N",         "frame, s", {}, {{0.002, 11, {}, 1}, {0.001, 10, {}, 1}},
                          {},           {0.1, 3, {}}};
  found.refinements = {refinement, free};
  found.checks = {{"volume", "mm³", Measure::relative, 100, 100.01, 2e-4, "the bar"},
                  {"force", "N", Measure::absolute, 0, 0, 0, "nothing is nothing"},
                  {"order", "", Measure::at_least, 1.8, 2, 0, "second order"},
                  {"ripple", "", Measure::reported, 0, 0.01, 0, "beside it"}};
  verify::Findings findings;
  findings.quick = true;
  findings.capabilities = {{"device", "a device"}, {"64-bit atomics", "no"}};
  findings.cases = {found};
  return findings;
}

TEST(VerifyReport, MarkdownHasEveryFigureWithItsReason) {
  const std::string text = verification_markdown(some_findings());
  for (const char* part : {"all cases passed", "a device", "## A cap", "π·d²·(R − d/3)",
                           "| volume, mm³ | 100 | 100.01 | +0.01 % | ±0.02 % | pass | the bar |",
                           "| order | ≥ 1.8 | 2 | – | – | pass | second order |", "Order of the error: 2.00",
                           "order from three levels alone: 2.10", "grid convergence index 0.1 % (safety factor 1.25)",
                           "verification.png"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  EXPECT_THAT(text, Not(HasSubstr("FAIL")));
}

TEST(VerifyReport, PageOfTheDeviceHasItsCapabilitiesAndCases) {
  verify::Findings findings = some_findings();
  EXPECT_THAT(device_markdown(findings), Not(HasSubstr("## A cap")));
  findings.device_cases = findings.cases;
  const std::string text = device_markdown(findings);
  for (const char* part : {"on `a device`", "1 of 1 cases of the quick suite passed", "| 64-bit atomics | `no` |",
                           "## A cap", "| volume, mm³ | 100 | 100 | pass |", "| ripple | 0.01 | – | – |"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  EXPECT_EQ(nlohmann::json::parse(verification_json(findings))["capabilities"]["64-bit atomics"], "no");
}

TEST(VerifyReport, AnErrorThatDoesNotDecreaseHasNoOrder) {
  verify::Findings findings = some_findings();
  findings.cases[0].refinements[0].order = -0.8;
  EXPECT_THAT(verification_markdown(findings),
              HasSubstr("Order of the error: none, the error does not decrease with the step;"));
}

TEST(VerifyReport, AFailureIsSaidInTheHeadAndInItsRow) {
  verify::Findings findings = some_findings();
  findings.cases[0].checks[0].found = 101;
  findings.cases[0].checks[1].found = std::numeric_limits<double>::quiet_NaN();
  const std::string text = verification_markdown(findings);
  EXPECT_THAT(text, HasSubstr("2 figures FAILED"));
  EXPECT_THAT(text, HasSubstr("| volume, mm³ | 100 | 101 | +1 % | ±0.02 % | **FAIL** | the bar |"));
  const auto json = nlohmann::json::parse(verification_json(findings));
  EXPECT_FALSE(json["passed"].get<bool>());
  EXPECT_EQ(json["failed_checks"], 2);
  EXPECT_TRUE(json["cases"][0]["checks"][1]["found"].is_null()) << "JSON has no NaN";
}

TEST(VerifyReport, JsonHasTheDocumentedKeys) {
  const auto json = nlohmann::json::parse(verification_json(some_findings()));
  for (const char* key : {"program", "device", "suite", "passed", "failed_checks", "seconds", "cases"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  const auto& found = json["cases"][0];
  for (const char* key : {"id", "title", "scene", "closed_form", "passed", "seconds", "ladders", "checks"}) {
    EXPECT_TRUE(found.contains(key)) << key;
  }
  for (const char* key : {"quantity", "unit", "step", "expected", "levels", "order", "order_of_three",
                          "grid_convergence_index", "safety_factor"}) {
    EXPECT_TRUE(found["ladders"][1].contains(key)) << key;
  }
  EXPECT_TRUE(found["ladders"][1]["expected"].is_null());
  for (const char* key :
       {"quantity", "unit", "measure", "expected", "found", "error", "tolerance", "reason", "passed"}) {
    EXPECT_TRUE(found["checks"][0].contains(key)) << key;
  }
}

TEST(VerifyReport, WritesFilesAndFigure) {
  const test::TempDir dir;
  write_verification(dir.path(), some_findings());
  const test::Picture figure = test::read_picture(dir.path() + "/verification.png");
  EXPECT_EQ(figure.width, 1800);
  int colored = 0;
  for (const std::uint32_t pixel : figure.pixels) colored += (pixel & 0xffffff) == 0x0072b2 ? 1 : 0;
  EXPECT_GT(colored, 100) << "the curve in its colour";
  EXPECT_THAT(test::file_bytes(dir.path() + "/verification.svg"), HasSubstr("</svg>"));
  EXPECT_THAT(test::file_bytes(dir.path() + "/verification.md"), HasSubstr("# Verification"));
}

TEST(VerifyReport, FolderThatIsNotThere) {
  EXPECT_THROW(write_verification("/nonexistent/folder", some_findings()), RunError);
}

}  // namespace
}  // namespace reamsim
