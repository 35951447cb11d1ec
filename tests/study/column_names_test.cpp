// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/study_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace reamsim::test {
namespace {

using ::testing::ElementsAre;

const std::string kForce = "headline.peak_axial_force_n";

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
