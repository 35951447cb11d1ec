// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/study_plan.h"
#include "tests/study/study_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class StudyPlanning : public StudyTest {};

TEST_F(StudyPlanning, CombinesTheFirstVariationSlowestAndSamplesFastest) {
  write("cohort.csv", "label,motion.plunge.dwell_s\na,0\nb,\n");
  const Study read = study(
      "set: {motion.plunge.feed_mm_s: 4}\nvary:\n  - motion.plunge.depth_mm: [1, 2]\ntable: cohort.csv\n"
      "sample: {method: monte_carlo, n: 2, of: {cutting.normal_ratio: {uniform: [0.4, 0.6]}}}\n");
  const StudyPlan plan = make_plan(read, {"engine.device=auto"});
  EXPECT_THAT(plan.columns,
              ElementsAre("label", "motion.plunge.depth_mm", "motion.plunge.dwell_s", "cutting.normal_ratio"));
  ASSERT_EQ(plan.runs.size(), 8U);
  const auto cells = [&](std::size_t i) {
    const auto& all = plan.runs[i].cells;
    return all[0] + " " + all[1] + " " + all[2];
  };
  EXPECT_EQ(cells(0), "a 1 0");
  EXPECT_EQ(cells(1), "a 1 0");
  EXPECT_EQ(cells(2), "b 1 ");
  EXPECT_EQ(cells(4), "a 2 0");
  EXPECT_EQ(plan.runs[0].cells[3], plan.runs[2].cells[3]) << "the samples are the same for every combination";
  EXPECT_NE(plan.runs[0].cells[3], plan.runs[1].cells[3]);
  EXPECT_EQ(plan.runs[7].number, 8);
  EXPECT_THAT(plan.runs[2].overrides, ElementsAre("motion.plunge.feed_mm_s=4", "engine.device=auto",
                                                  "motion.plunge.depth_mm=1", HasSubstr("cutting.normal_ratio=0.")));
}

TEST_F(StudyPlanning, TiltsAndShiftsChangeTheVectorOfTheRun) {
  const Study read = study(
      "vary: [{motion.plunge.entry_mm: [[0, 0, 0], [1, 2, 3]]}]\n"
      "sample: {n: 8, of: {motion.plunge.entry_mm: {shift_sd_mm: 0.5}, motion.plunge.axis: {tilt_sd_deg: 2}}}\n");
  const StudyPlan plan = make_plan(read);
  EXPECT_THAT(plan.columns,
              ElementsAre("motion.plunge.entry_mm", "motion.plunge.entry_mm.shift_x_mm",
                          "motion.plunge.entry_mm.shift_y_mm", "motion.plunge.entry_mm.shift_z_mm",
                          "motion.plunge.axis", "motion.plunge.axis.tilt_1_deg", "motion.plunge.axis.tilt_2_deg"));
  ASSERT_EQ(plan.runs.size(), 16U);
  for (const PlannedRun& run : plan.runs) {
    const Scenario scenario = scenario_of(read, run);
    const Vec3 shift(std::stod(run.cells[1]), std::stod(run.cells[2]), std::stod(run.cells[3]));
    const Vec3 entry = run.number <= 8 ? Vec3(0, 0, 0) : Vec3(1, 2, 3);
    EXPECT_TRUE(scenario.motion.plunge->entry_mm.isApprox(entry + shift, 1e-12)) << run.number;
    const Vec3 axis = tilted(Vec3(0, 0, -1), std::stod(run.cells[5]), std::stod(run.cells[6]));
    EXPECT_TRUE(scenario.motion.plunge->axis.isApprox(axis, 1e-12)) << run.number;
  }
}

TEST_F(StudyPlanning, AVectorThatNobodyGivesCannotBeChanged) {
  const Study read = study("sample: {n: 2, of: {bone.glenoid.normal: {tilt_sd_deg: 2}}}\n");
  try {
    make_plan(read);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("bone.glenoid.normal: has no vector that the sample could change"));
  }
}

TEST_F(StudyPlanning, TooManyRunsAreRefused) {
  std::string levels = "[0";
  for (int i = 1; i < 101; ++i) levels += ", " + std::to_string(i);
  levels += "]";
  const Study read = study("vary:\n  - motion.plunge.spin_rpm: " + levels + "\n  - motion.plunge.dwell_s: " + levels +
                           "\n  - motion.plunge.retract_mm: " + levels + "\n");
  EXPECT_THROW(make_plan(read), InputError);
}

TEST_F(StudyPlanning, WrongScenariosAreToldByRun) {
  const Study read = study("vary: [{motion.plunge.depth_mm: [1, -1, deep]}]\n");
  const std::vector<IdentifiedRun> runs = identify_runs(read, make_plan(read));
  ASSERT_EQ(runs.size(), 3U);
  EXPECT_EQ(runs[0].mistake, "");
  EXPECT_EQ(runs[0].id.size(), 16U);
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_EQ(runs[i].id, "");
    EXPECT_THAT(runs[i].mistake, HasSubstr("motion.plunge.depth_mm"));
  }
}

TEST_F(StudyPlanning, AMissingFileHidesNoOtherMistakeOfItsRow) {
  write("cohort.csv",
        "tool.mesh,bone.voxel_mm,motion.plunge.depth_mm\nnone.stl,-1,deep\nflat.stl,1,1\n${REAMSIM_UNSET}/x.stl,1,1\n");
  const Study read = study("table: cohort.csv\n");
  const std::vector<IdentifiedRun> runs = identify_runs(read, make_plan(read));
  ASSERT_EQ(runs.size(), 3U);
  EXPECT_THAT(runs[0].mistake,
              AllOf(HasSubstr("cohort.csv:2: tool.mesh: no such file"), HasSubstr(" | "),
                    HasSubstr("bone.voxel_mm: found -1"), HasSubstr("motion.plunge.depth_mm: found the text")));
  EXPECT_EQ(runs[0].mistake.find('\n'), std::string::npos);
  EXPECT_EQ(runs[1].mistake, "");
  EXPECT_THAT(runs[2].mistake, AllOf(HasSubstr("cohort.csv:4: tool.mesh: "), HasSubstr("is not set")));
}

TEST_F(StudyPlanning, AKeyThatOnlyTheTableHasIsNotMissingWhereItsFileIs) {
  write("base.yaml",
        "version: 2\nbone: {source: mesh, voxel_mm: 1}\ntool: {mesh: flat.stl}\n"
        "motion: {plunge: {entry_mm: [0, 0, 0], axis: [0, 0, -1], feed_mm_s: 5, depth_mm: 1}}\n");
  write("cohort.csv", "bone.mesh.path\nnone.stl\n");
  const Study read = study("table: cohort.csv\n");
  const std::vector<IdentifiedRun> runs = identify_runs(read, make_plan(read));
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_THAT(runs[0].mistake, HasSubstr("cohort.csv:2: bone.mesh.path: no such file"));
  EXPECT_EQ(runs[0].mistake.find(" | "), std::string::npos) << runs[0].mistake;
}

}  // namespace
}  // namespace reamsim::test
