// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/main_effects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/study/run_table_maker.h"

namespace reamsim::test {
namespace {

using ::testing::ElementsAre;

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();
const std::string kForce = "headline.peak_axial_force_n", kVolume = "removed_mm3";

const MainEffect& effect_on(const MainEffects& effects, const std::string& parameter, const std::string& result) {
  const auto p = std::ranges::find(effects.parameters, parameter, [](const auto& each) { return each.name.key; });
  const auto r = std::ranges::find(effects.results, result, [](const auto& each) { return each.name.key; });
  if (p == effects.parameters.end() || r == effects.results.end()) throw std::out_of_range(parameter + ", " + result);
  return effects.effects[static_cast<std::size_t>(p - effects.parameters.begin())]
                        [static_cast<std::size_t>(r - effects.results.begin())];
}

/// y = a·depth + b(tool) in a full grid: sums of squares are those of the terms.
TEST(MainEffects, OfAnAdditiveModelAreItsTerms) {
  TableMaker maker({"motion.plunge.depth_mm", "tool.mesh"}, {kForce});
  for (const double depth : {1.0, 2.0, 4.0}) {
    for (const auto& [tool, b] : {std::pair{"a/reamer_flat.stl", 0.0}, std::pair{"a/reamer_convex.stl", 6.0}}) {
      maker.done({std::to_string(static_cast<int>(depth)), tool}, {3 * depth + b});
    }
  }
  const MainEffects effects = main_effects(maker.table());
  const MainEffect& depth = effect_on(effects, "motion.plunge.depth_mm", kForce);
  ASSERT_EQ(depth.groups.size(), 3U);
  EXPECT_DOUBLE_EQ(depth.groups[2].x, 4);
  EXPECT_DOUBLE_EQ(depth.groups[2].mean, 15);
  EXPECT_DOUBLE_EQ(depth.groups[2].sd, 6 / std::sqrt(2.0));
  EXPECT_EQ(depth.groups[2].runs, 2);
  // Variances of the terms: 9·(14/9) of the depth, 9 of the tool.
  EXPECT_NEAR(depth.explained, 14.0 / 23, 1e-12);
  EXPECT_NEAR(effect_on(effects, "tool.mesh", kForce).explained, 9.0 / 23, 1e-12);
  EXPECT_EQ(effects.parameters[0].name.key, "motion.plunge.depth_mm") << "the dominant one first";
  EXPECT_THAT(effects.parameters[1].levels, ElementsAre("flat", "convex")) << "in the order of the plan";
  EXPECT_THAT(effects.parameters[0].levels, ElementsAre("1", "2", "4"));
}

/// y = x₁ + e with uniform x₁ and e of the same variance; x₂ changes nothing.
TEST(MainEffects, OfSampledParametersAreMeansOverIntervals) {
  TableMaker maker({"cutting.normal_ratio", "cutting.specific_energy_j_mm3"}, {kForce});
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  constexpr int kRuns = 4000;
  for (int i = 0; i < kRuns; ++i) {
    const double x = uniform(random);
    maker.done({std::to_string(x), std::to_string(uniform(random))}, {x + uniform(random)});
  }
  const MainEffects effects = main_effects(maker.table());
  const MainEffect& first = effect_on(effects, "cutting.normal_ratio", kForce);
  ASSERT_EQ(first.groups.size(), 8U);
  for (std::size_t g = 0; g < 8; ++g) {
    EXPECT_NEAR(first.groups[g].runs, kRuns / 8, 8) << "some values are equal to six decimals";
    EXPECT_NEAR(first.groups[g].mean, first.groups[g].x + 0.5, 0.06) << g;
    EXPECT_LT(first.groups[g].from, first.groups[g].to);
  }
  EXPECT_NEAR(first.explained, 0.5, 0.03) << "half of the variance, less 1/64 within intervals";
  EXPECT_LT(effect_on(effects, "cutting.specific_energy_j_mm3", kForce).explained, 0.005) << "corrected for chance";
}

TEST(MainEffects, LeaveOutWhatIsNoParameter) {
  TableMaker maker({"label", "bone.ct.path", "bone.glenoid.normal", "bone.glenoid.normal.tilt_1_deg", "bone.side"},
                   {kForce, kVolume, "headline.depth_mm"});
  for (int i = 0; i < 24; ++i) {
    const std::string patient = std::to_string(i % 3);
    const std::string run = std::to_string(i);
    maker.done({"P" + patient, "scans/p" + patient + ".nrrd", "[0, 0." + run + ", 1]", "0." + run, "left"},
               {1.0 * (i % 3), 5, i == 4 ? kMissing : 0.1 * i});
  }
  const MainEffects effects = main_effects(maker.table());
  std::vector<std::string> keys;
  for (const EffectParameter& parameter : effects.parameters) keys.push_back(parameter.name.key);
  EXPECT_THAT(keys, ::testing::UnorderedElementsAre("label", "bone.glenoid.normal.tilt_1_deg"));
  const auto label = std::ranges::find(effects.parameters, "label", [](const auto& each) { return each.name.key; });
  EXPECT_THAT(label->with, ElementsAre("bone.ct.path")) << "varies together with the label";
  std::vector<std::string> results;
  for (const EffectResult& result : effects.results) results.push_back(result.name.key);
  EXPECT_THAT(results, ElementsAre(kForce, "headline.depth_mm")) << "the volume does not vary";
  int runs = 0;
  for (const EffectGroup& group : effect_on(effects, "label", "headline.depth_mm").groups) runs += group.runs;
  EXPECT_EQ(runs, 23) << "a missing value is left out";
}

TEST(MainEffects, NeedTwoFinishedRuns) {
  TableMaker maker({"motion.plunge.depth_mm"}, {kForce});
  EXPECT_TRUE(main_effects(maker.table()).empty());
  maker.done({"1"}, {1}).failed({"2"}, "no").failed({"3"}, "no");
  EXPECT_TRUE(main_effects(maker.table()).empty());
  maker.done({"4"}, {2});
  const MainEffects effects = main_effects(maker.table());
  ASSERT_FALSE(effects.empty());
  EXPECT_THAT(effects.runs, ElementsAre(0U, 3U));
  EXPECT_EQ(effects.effects[0][0].groups[0].sd, 0);
}

TEST(MainEffects, RoundingIsNoVariation) {
  TableMaker maker({"motion.plunge.depth_mm"}, {kForce});
  maker.done({"1"}, {0.3}).done({"2"}, {0.1 + 0.2});
  EXPECT_TRUE(main_effects(maker.table()).empty());
  // Nor are the hundredths of a degree of a fitted face.
  TableMaker angles({"motion.plunge.depth_mm"},
                    {"metrics.orientation.reamed.version_deg", "metrics.orientation.reamed.inclination_deg"});
  angles.done({"1"}, {5.01, 6}).done({"2"}, {5.09, 7});
  const MainEffects effects = main_effects(angles.table());
  ASSERT_EQ(effects.results.size(), 1U);
  EXPECT_EQ(effects.results[0].name.key, "metrics.orientation.reamed.inclination_deg");
}

TEST(RunsOfTable, AreAllOrDrawnAtRandom) {
  EXPECT_EQ(std::ranges::count(runs_of_table(10, 10), true), 10);
  const std::vector<bool> some = runs_of_table(1000, 100);
  EXPECT_EQ(std::ranges::count(some, true), 100);
  EXPECT_EQ(some, runs_of_table(1000, 100));
  int even = 0;
  for (std::size_t i = 0; i < some.size(); i += 2) even += some[i] ? 1 : 0;
  EXPECT_NEAR(even, 50, 20) << "every second run would be one level of the fastest parameter";
}

TEST(ColumnNames, AreReadableAndUnique) {
  const auto titles = [](const std::vector<std::string>& keys) {
    std::vector<std::string> out;
    for (const ColumnName& name : column_names(keys)) out.push_back(name.title());
    return out;
  };
  EXPECT_THAT(titles({"motion.plunge.depth_mm", "cutting.specific_energy_j_mm3", "tool.mesh",
                      "bone.glenoid.center_mm.shift_x_mm", "removed_mm3", "energy_mj", "metrics.depth.area_mm2",
                      "metrics.dense_bone_left.exposed_percent", "passes.0.tool.mesh"}),
              ElementsAre("Plunge depth (mm)", "Specific energy (J/mm³)", "Tool mesh", "Center shift x (mm)",
                          "Removed volume (mm³)", "Cutting energy (mJ)", "Depth area (mm²)",
                          "Dense bone left exposed (%)", "Passes 0 tool mesh"));
  const std::vector<std::string> same = titles(
      {"forces.peak_axial_force_n", kForce, "metrics.a.points", "metrics.b.a.points", "bone.dims.0", "bone.dims.1"});
  EXPECT_EQ(same[1], "Peak axial force (N)") << "headline results keep their names";
  EXPECT_EQ(same[0], "Forces peak axial force (N)");
  EXPECT_NE(same[2], same[3]);
  EXPECT_NE(same[4], same[5]);
}

TEST(ColumnNames, OfCells) {
  EXPECT_EQ(shown_cell("../../assets/reamer_flat.stl"), "reamer_flat");
  EXPECT_EQ(shown_cell("0.123456"), "0.1235");
  EXPECT_EQ(shown_cell("reamer_flat.stl"), "reamer_flat");
  EXPECT_EQ(shown_cell("Miller, A."), "Miller, A.");
  EXPECT_EQ(shown_cell("left"), "left");
  EXPECT_EQ(shown_cell(""), "as in the base");
}

}  // namespace
}  // namespace reamsim::test
