// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The page of a study.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "render/viewer/page.h"
#include "tests/study/run_table_maker.h"

namespace reamsim::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<std::string> kResults{"headline.peak_axial_force_n", "headline.peak_spin_torque_nmm", "removed_mm3",
                                        "headline.depth_mm", "energy_mj"};

/// A grid of tools and depths with a sample; some runs failed.
RunTable grid(int samples, const std::string& tool = "tools/reamer_") {
  TableMaker maker({"tool.mesh", "motion.plunge.depth_mm", "cutting.normal_ratio"}, kResults);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(0.4, 0.6);
  for (const std::string name : {"flat", "convex", "hemispherical"}) {
    for (const int depth : {1, 2}) {
      for (int i = 0; i < samples; ++i) {
        const double k = uniform(random), f = static_cast<double>(name.size() * depth) * k;
        if (i == 3) {
          maker.failed({tool + name + ".stl", std::to_string(depth), std::to_string(k)}, "</script> \"broken\", 'x'");
        } else {
          maker.done({tool + name + ".stl", std::to_string(depth), std::to_string(k)},
                     {f, 12 * f, 10.0 * depth, 1.0 * depth, 150 * f});
        }
      }
    }
  }
  return maker.table();
}

/// The data in a page.
nlohmann::json data_of(const std::string& page) {
  const std::string mark = "id=\"page-data\">";
  const std::size_t from = page.find(mark) + mark.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
}

TEST(StudyPage, HasEveryRunAndNoNetwork) {
  const std::string page = study_page("my <study>", grid(5));
  EXPECT_THAT(page, HasSubstr("<title>my &lt;study&gt; "));
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  for (const char* word : {"http://", "https://"}) {
    std::string text = page;
    for (const char* harmless : {"http://www.w3.org/2000/svg", "https://github.com"}) {
      for (std::size_t at = 0; (at = text.find(harmless)) != std::string::npos;)
        text.erase(at, std::string(harmless).size());
    }
    EXPECT_THAT(text, Not(HasSubstr(word)));
  }
  const auto data = data_of(page);
  EXPECT_EQ(data["runs"], 30);
  EXPECT_EQ(data["all"], 30);
  EXPECT_THAT(data["messages"]["texts"], Contains("</script> \"broken\", 'x'"));
  EXPECT_EQ(data["columns"][0]["levels"], (nlohmann::json{"reamer_flat", "reamer_convex", "reamer_hemispherical"}));
  EXPECT_EQ(data["columns"][1]["unit"], "mm");
  EXPECT_FALSE(data["columns"][2].contains("levels")) << "a sampled number";
  EXPECT_EQ(study_page("a", grid(5)), study_page("a", grid(5))) << "the same on every call";
}

TEST(StudyPage, StaysBelowItsLimit) {
  const RunTable table = grid(2000);
  const std::size_t whole = study_page("large", table).size();
  const std::size_t most = whole - 20'000;
  const std::string page = study_page("large", table, most);
  EXPECT_LE(page.size(), most);
  const auto data = data_of(page);
  EXPECT_EQ(data["all"], 12000);
  EXPECT_EQ(data["runs"], 6000);
  EXPECT_EQ(data["columns"][0]["levels"].size(), 3U) << "runs are drawn from all levels";
}

TEST(StudyPage, OfAStudyWithoutResults) {
  TableMaker maker({"motion.plunge.depth_mm"}, {});
  EXPECT_EQ(data_of(study_page("empty", maker.failed({"1"}, "no").failed({"2"}, "no").table()))["runs"], 2);
}

}  // namespace
}  // namespace reamsim::test
