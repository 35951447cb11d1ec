// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/viewer/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "render/gl/camera.h"
#include "render/pictures/renderer.h"
#include "sim/base/error.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

using Json = nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr const char* kHostile = "</script><script>alert(1)</script><!-- \" & '";

std::string read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void write(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

nlohmann::json small_summary() {
  return {{"program", "reamsim 9.9.9"},
          {"scenario", kHostile},
          {"device", "a device"},
          {"engine", "bricked"},
          {"erosion", "exact"},
          {"law", "energy"},
          {"removed_mm3", 726.66},
          {"balance", -8.2e-8},
          {"metrics", {{"depth", nullptr}, {"perforation", {{"perforated", false}}}}},
          {"inputs", {{{"role", "scenario"}, {"path", "/home/x/<b>.yaml"}, {"sha256", "abc123"}}}},
          {"warnings", {"mind the <gap>"}}};
}

/// The data that the page carries for its scripts.
nlohmann::json data_of(const std::string& page) {
  const std::string open = "<script type=\"application/json\" id=\"page-data\">";
  const std::size_t from = page.find(open) + open.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
}

/// The rows of the table with this title; null without it.
nlohmann::json table(const nlohmann::json& tables, const std::string& title) {
  for (const nlohmann::json& table : tables) {
    if (table["title"] == title) return table["rows"];
  }
  return nullptr;
}

/// A run, made once; tests work on copies of its folder.
class ReportPage : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    run_ = new test::TempDir;
    write_results(run_->path(), {.voxel_mm = 1.0});
    write(run_->path() + "/summary.json", small_summary().dump());
    write(run_->path() + "/scenario.yaml", std::string("version: 2  # ") + kHostile + "\n");
    fs::create_directory(run_->path() + "/frames");
    PixelImage picture = plain_image(160, 90, 0x336699);
    for (const char* name : {"reamed", "reamed_section", "frames/000000", "frames/000020", "frames/000040",
                             "frames/000060", "frames/000000_section", "frames/000020_section"}) {
      write_png(run_->path() + "/" + name + ".png", picture);
    }
  }
  static void TearDownTestSuite() { delete run_; }

  void SetUp() override {
    fs::copy(run_->path(), dir(), fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    settings_.cameras = {CameraView::oblique, CameraView::section};
  }

  [[nodiscard]] std::string dir() const { return copy_.path(); }
  void write_page(const RunData& run) {
    write_report(run, settings_, report_parts(run, settings_, [&] { return bone_data(run, settings_); }));
  }
  std::string page() {
    write_page(dir());
    return read(dir() + "/report.html");
  }
  void expect_refused(const std::string& part) {
    try {
      write_page(dir());
      ADD_FAILURE() << "no error";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(part));
    }
    EXPECT_FALSE(fs::exists(dir() + "/report.html"));
  }

  RenderSettings settings_;

 private:
  static test::TempDir* run_;
  test::TempDir copy_;
};

test::TempDir* ReportPage::run_ = nullptr;

TEST_F(ReportPage, HoldsTheRun) {
  const std::string text = page();
  const nlohmann::json data = data_of(text);
  const nlohmann::json& summary = data["summary"];
  EXPECT_EQ(summary["key_figures"], Json({{"Bone removed", 726.66, "mm³"}, {"Energy balance", -8.2e-8, ""}}));
  EXPECT_EQ(table(summary["measurements"], "Remaining bone under the face"), Json({{"Perforated", false, ""}}));
  EXPECT_EQ(table(summary["provenance"], "Inputs"), Json({{"scenario", "<b>.yaml", "abc123"}}));
  EXPECT_EQ(summary["warnings"], Json({"mind the <gap>"}));
  EXPECT_EQ(data["plot"]["frame"].size(), 60u);
  EXPECT_EQ(data["pictures"]["frames"], nlohmann::json({0, 20, 40, 60}));
  ASSERT_EQ(data["pictures"]["cameras"].size(), 1u) << "a camera whose pictures are not all there is left out";
  EXPECT_EQ(data["pictures"]["cameras"][0]["jpegs"].size(), 4u);
  EXPECT_EQ(data["pictures"]["cameras"][0]["width_px"], 160);
  EXPECT_NEAR(data["bone"]["deepest_mm"].get<double>(), 3.0, 0.6);
  for (const char* state : {"before", "after"}) EXPECT_GT(data["bone"][state]["triangles"], 1000) << state;
}

TEST_F(ReportPage, HasTheReamerAndTheReamingAlongTheRun) {
  const nlohmann::json data = data_of(page());
  EXPECT_GE(data["tool"]["passes"][0]["mesh"]["triangles"], 12);
  EXPECT_TRUE(data["tool"]["shown"]);
  EXPECT_EQ(data["tool"]["look"], "see-through");
  EXPECT_EQ(data["tool"]["poses"]["count"], data["plot"]["frame"].size());
  const nlohmann::json& reaming = data["bone"]["reaming"];
  EXPECT_EQ(reaming["time_s"].size(), 4u) << "one for each snapshot";
  EXPECT_GT(reaming["vertices"], 20);
  EXPECT_NEAR(reaming["most_mm"].get<double>(), 3.0, 0.8) << "the depth of the final bone";
}

TEST_F(ReportPage, HidesTheReamerThatPicturesHide) {
  settings_.tool = false;
  EXPECT_FALSE(data_of(page())["tool"]["shown"]);
}

TEST_F(ReportPage, IsTheSameAfterPicturesOfTheSameRun) {
  const std::string alone = page();
  const RunData run(dir());
  {
    // Left in the midst of the run.
    const RunView view(run, settings_);
    Renderer renderer(view);
    renderer.advance_to(view.frames().at(1));
  }
  write_page(run);
  EXPECT_TRUE(read(dir() + "/report.html") == alone);
}

TEST_F(ReportPage, NothingFromTheRunBecomesMarkup) {
  const std::string text = page();
  EXPECT_THAT(text, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(text, Not(HasSubstr("<gap>")));
  EXPECT_THAT(text, Not(HasSubstr("<b>")));
  EXPECT_THAT(text, HasSubstr("&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt;&lt;!-- &quot; &amp; &#39;"));
}

TEST_F(ReportPage, IsReadableWithoutScripts) {
  const std::string text = page();
  const std::size_t from = text.find("<noscript>\n");
  const std::string plain = text.substr(from, text.find("</noscript>", from) - from);
  for (const char* part : {"Bone removed</td><td>726.66</td><td>mm³", "-8.2e-08", "Perforated</td><td>no", "abc123",
                           "mind the &lt;gap&gt;"}) {
    EXPECT_THAT(plain, HasSubstr(part));
  }
}

TEST_F(ReportPage, AsksForNothing) {
  const std::string text = page();
  EXPECT_THAT(text, HasSubstr("Content-Security-Policy\" content=\"default-src 'none'"));
  const std::string head = text.substr(0, text.find("id=\"page-data\""));
  for (const char* way : {"src=\"http", "href=\"http", "url(http", "@import"}) EXPECT_THAT(head, Not(HasSubstr(way)));
}

TEST_F(ReportPage, SameResultsGiveTheSameBytes) {
  const std::string once = page();
  EXPECT_EQ(page(), once);
}

TEST_F(ReportPage, SaysWhatIsKnownOfVerification) {
  const auto known = [this] { return data_of(page())["summary"]["verification"]; };
  EXPECT_TRUE(known().is_null());
  const nlohmann::json verification{
      {"program", "reamsim 9.9.9"}, {"device", "another"}, {"suite", "full"}, {"passed", true}, {"cases", {1, 2}}};
  write(dir() + "/verification.json", verification.dump());
  EXPECT_EQ(known(), Json({{"passed", true},
                           {"suite", "full"},
                           {"cases", 2},
                           {"program", "reamsim 9.9.9"},
                           {"device", "another"},
                           {"differs", Json::array({"device"})}}));
  auto failed = verification;
  failed["passed"] = false;
  write(dir() + "/verification.json", failed.dump());
  EXPECT_FALSE(known()["passed"]);
}

TEST_F(ReportPage, DoesWithoutPictures) {
  fs::remove_all(dir() + "/frames");
  fs::remove(dir() + "/reamed.png");
  const nlohmann::json data = data_of(page());
  EXPECT_TRUE(data["pictures"]["cameras"].empty());
}

TEST_F(ReportPage, RefusesDamagedResults) {
  write(dir() + "/summary.json", "{\"program\": ");
  expect_refused("summary.json");
  write(dir() + "/summary.json", "{}");
  expect_refused("scenario");
  auto summary = small_summary();
  summary["inputs"] = 3;
  write(dir() + "/summary.json", summary.dump());
  expect_refused("inputs");
  summary = small_summary();
  summary["removed_mm3"] = {1, 2};
  write(dir() + "/summary.json", summary.dump());
  expect_refused("removed_mm3");
}

TEST_F(ReportPage, RefusesADamagedPicture) {
  write(dir() + "/reamed.png", "no picture");
  expect_refused("reamed.png");
}

TEST_F(ReportPage, RefusesADamagedVerification) {
  write(dir() + "/verification.json", "{\"passed\": \"yes\"}");
  expect_refused("verification.json");
}

TEST_F(ReportPage, RefusesAFolderWithoutItsScenario) {
  fs::remove(dir() + "/scenario.yaml");
  expect_refused("scenario.yaml");
}

}  // namespace
}  // namespace reamsim
