// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What people see of a study: figure, page, table on the terminal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>

#include "render/study/effects_plot.h"
#include "render/study/effects_table.h"
#include "render/viewer/study_page.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "tests/study/run_table_maker.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
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

TEST(EffectsPlot, HasAFigureAScriptAndItsNumbers) {
  const TempDir dir;
  const MainEffects effects = main_effects(grid(20));
  write_main_effects(dir.path(), effects);
  for (const char* name : {"effects.png", "effects.svg", "effects.pdf", "effects.gp"}) {
    EXPECT_GT(std::filesystem::file_size(dir.path() + "/" + name), 1000U) << name;
  }
  const std::string csv = read_file(dir.path() + "/effects.csv", "");
  EXPECT_THAT(csv, HasSubstr("parameter,result,level,from,to,runs,mean,sd,explained\n"));
  EXPECT_THAT(csv, HasSubstr("tool.mesh,removed_mm3,hemispherical,,,38,"));
  EXPECT_THAT(csv, HasSubstr("motion.plunge.depth_mm,removed_mm3,2,2,2,57,20,0,1\n"));
  EXPECT_THAT(csv, HasSubstr("cutting.normal_ratio,energy_mj,,0.40"));
  const std::string svg = read_file(dir.path() + "/effects.svg", "");
  for (const char* text : {"hemispherical", "Plunge depth (mm)", "Mean ± SD", "100 %"})
    EXPECT_THAT(svg, HasSubstr(text));
}

TEST(EffectsPlot, NamesAreNoCommands) {
  const TempDir dir;
  TableMaker maker({"label"}, {"removed_mm3"});
  const std::string evil = "`touch " + dir.path() + "/run`";
  for (int i = 0; i < 6; ++i) maker.done({i % 2 == 0 ? evil : "it's, \"B\" $(touch x) \\n {/b}"}, {1.0 * i});
  write_main_effects(dir.path(), main_effects(maker.table()));
  EXPECT_FALSE(std::filesystem::exists(dir.path() + "/run"));
  EXPECT_GT(std::filesystem::file_size(dir.path() + "/effects.png"), 1000U);
}

TEST(EffectsPlot, OfManyParametersHasThoseThatExplainMost) {
  std::vector<std::string> keys;
  for (int p = 0; p < 12; ++p) keys.push_back("section.parameter_number_" + std::to_string(p));
  TableMaker maker(keys, {"removed_mm3"});
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int i = 0; i < 400; ++i) {
    std::vector<std::string> cells;
    double sum = 0;
    for (int p = 0; p < 12; ++p) {
      const double x = uniform(random);
      cells.push_back(std::to_string(x));
      sum += x * p;
    }
    maker.done(cells, {sum});
  }
  const MainEffects effects = main_effects(maker.table());
  const TempDir dir;
  write_main_effects(dir.path(), effects);
  const std::string script = read_file(dir.path() + "/effects.gp", "");
  EXPECT_THAT(script, AllOf(HasSubstr("parameters = 6\n"), HasSubstr("number 11"), HasSubstr("number 8")));
  EXPECT_THAT(script, Not(HasSubstr("number 1'")));
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

TEST(StudyTable, FitsTheTerminal) {
  for (const int samples : {2, 5, 200}) {
    const RunTable table = grid(samples, "a_long_folder/with_a_very_long_name_of_a_reamer_");
    const std::vector<std::string> lines = study_table(table, main_effects(table), 100);
    ASSERT_GT(lines.size(), 5U) << samples;
    for (const std::string& line : lines) EXPECT_LE(text_width(line), 100U) << line;
  }
}

TEST(StudyTable, HasARowPerRunOrPerLevel) {
  const RunTable few = grid(2), many = grid(10);
  EXPECT_THAT(study_table(few, main_effects(few), 100), Contains(HasSubstr("done")).Times(12));
  const std::vector<std::string> lines = study_table(many, main_effects(many), 100);
  EXPECT_THAT(lines, Contains(AllOf(HasSubstr("Plunge depth (mm)"), HasSubstr(" 1 "), HasSubstr(" 27 "))));
  EXPECT_THAT(lines, Contains(AllOf(HasSubstr("all"), HasSubstr(" 54 "), HasSubstr(" ± "))));
}

TEST(StudyTable, OfASampleHasQuantiles) {
  TableMaker maker({"cutting.normal_ratio"}, {"removed_mm3"});
  for (int i = 0; i <= 100; ++i) maker.done({std::to_string(0.001 * i)}, {1.0 * i});
  const std::vector<std::string> lines = study_table(maker.table(), main_effects(maker.table()), 100);
  // The deviation is 29.3: two digits of it leave no decimals.
  EXPECT_THAT(lines,
              Contains(::testing::ContainsRegex("Removed volume .mm³. +5 +50 +95 +Normal ratio \\(9[0-9] %\\)")));
  EXPECT_THAT(study_table(grid(1), main_effects(grid(1)), 100), Not(Contains(HasSubstr("over all runs"))));
}

TEST(StudyTable, ShortensListsLegibly) {
  TableMaker maker({"bone.glenoid.center_mm", "label"}, {"removed_mm3"});
  maker.done({"[-41.200000, 9.200000, 36.600000]", "a name of more than twenty-four letters"}, {1});
  maker.done({"[4958.800000, 5009.200000, 5036.600000]", "short"}, {2});
  const std::vector<std::string> lines = study_table(maker.table(), {}, 100);
  EXPECT_THAT(lines, Contains(AllOf(HasSubstr("[-41.2, 9.2, 36.6]"), HasSubstr("a name of more than twe…"))));
  EXPECT_THAT(lines, Contains(HasSubstr("[4959, 5009, 5037]")));
}

TEST(StudyTable, HasNumbersWhereAllRunsAreEqual) {
  TableMaker maker({"label"}, {"removed_mm3"});
  maker.done({"A"}, {12.5}).done({"A"}, {12.5});
  EXPECT_THAT(study_table(maker.table(), {}, 100), Contains(HasSubstr("12.5")).Times(2));
}

TEST(StudyTable, IsEmptyWithoutResults) {
  TableMaker maker({"motion.plunge.depth_mm"}, {});
  const RunTable& table = maker.failed({"1"}, "no").table();
  EXPECT_TRUE(study_table(table, main_effects(table), 100).empty());
}

}  // namespace
}  // namespace reamsim::test
