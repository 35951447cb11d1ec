// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/study/study_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class StudyReader : public StudyTest {};

TEST_F(StudyReader, ReadsEveryKey) {
  write("cohort.csv", "label,bone.voxel_mm,tool.mesh\nfirst,0.5,convex.stl\n\"second, \"\"b\"\"\",,flat.stl\r\n");
  const Study read = study(
      "name: mine\nset: {motion.plunge.feed_mm_s: 4}\n"
      "vary:\n  - motion.plunge.depth_mm: [1, 2]\n  - zip: {motion.plunge.spin_rpm: [1, 2], motion.plunge.dwell_s: [0, "
      "1]}\n"
      "table: cohort.csv\n"
      "sample: {method: latin_hypercube, n: 3, seed: 7, of: {cutting.normal_ratio: {normal: [0.5, 0.1]}}}\n"
      "keep: [summary, forces, vdb]\n");
  EXPECT_EQ(read.name, "mine");
  EXPECT_EQ(read.base, path("base.yaml"));
  EXPECT_THAT(read.set, ElementsAre("motion.plunge.feed_mm_s=4"));
  ASSERT_EQ(read.vary.size(), 2U);
  EXPECT_THAT(read.vary[1].keys, ElementsAre("motion.plunge.spin_rpm", "motion.plunge.dwell_s"));
  EXPECT_EQ(read.vary[1].levels[1][1].applied, "1");
  EXPECT_THAT(read.table->labels, ElementsAre("first", "second, \"b\""));
  EXPECT_EQ(read.table->levels[1][0].applied, "") << "an empty cell leaves the base scenario's value";
  EXPECT_EQ(read.table->levels[0][1].shown, "convex.stl");
  EXPECT_THAT(read.table->levels[0][1].applied, HasSubstr("/convex.stl")) << "relative to the study";
  EXPECT_EQ(read.sample->method, SampleMethod::latin_hypercube);
  EXPECT_TRUE(read.keep.forces && read.keep.grids && !read.keep.pictures);
}

TEST_F(StudyReader, ReadsTablesOfSpreadsheets) {
  // A byte order mark, CRLF, quotes with a comma and a line end, blanks, empty cells, and blank lines below.
  write("cohort.csv",
        "\xEF\xBB\xBF\"label\", tool.mesh ,motion.plunge.entry_mm\r\n"
        "\"Müller, A.\r\n(left)\",\"convex.stl\",\"[1, 2, 3]\"\r\n\r\n"
        "  P02 ,,\"[0, 0.5, 0]\"\r\n,,\r\n ,,\r\n");
  const Study read = study("table: cohort.csv\n");
  EXPECT_THAT(read.table->keys, ElementsAre("tool.mesh", "motion.plunge.entry_mm"));
  EXPECT_THAT(read.table->labels, ElementsAre("Müller, A.\r\n(left)", "P02"));
  ASSERT_EQ(read.table->levels.size(), 2U);
  EXPECT_THAT(read.table->levels[0][0].applied, HasSubstr("/convex.stl"));
  EXPECT_EQ(read.table->levels[0][1].applied, "[1, 2, 3]");
  EXPECT_EQ(read.table->levels[1][0].applied, "");
}

TEST_F(StudyReader, MistakesNameLineColumnAndRemedy) {
  EXPECT_THAT(mistakes("vari: []\n"),
              AllOf(HasSubstr("study.yaml:3:1: vari: unknown key"), HasSubstr("did you mean vary?")));
  EXPECT_THAT(mistakes("vary: [{motion.plunge.dept_mm: [1]}]\n"),
              AllOf(HasSubstr("motion.plunge.dept_mm: unknown key"), HasSubstr("did you mean depth_mm (mm)?")));
  EXPECT_THAT(mistakes("vary: [{motion.plunge: [1]}]\n"), HasSubstr("motion.plunge: is a section"));
  EXPECT_THAT(mistakes("vary: [{motion.passes: [[]]}]\n"),
              HasSubstr("motion.passes: is a list; name a key of an entry, as in motion.passes.0.tool"));
  EXPECT_THAT(mistakes("vary: [{motion.plunge.depth_mm: 1}]\n"), HasSubstr("found 1; expected a list of values"));
  EXPECT_THAT(mistakes("vary: [{motion.plunge.depth_mm: [1], motion.plunge.spin_rpm: [2]}]\n"),
              HasSubstr("two keys in one entry of the list"));
  EXPECT_THAT(mistakes("vary: [{zip: {motion.plunge.depth_mm: [1, 2], motion.plunge.spin_rpm: [2]}}]\n"),
              HasSubstr("expected 2 values, as many as the first key of zip has"));
  EXPECT_THAT(mistakes("vary: [{tool.mesh: [none.stl]}]\n"), AllOf(HasSubstr("tool.mesh"), HasSubstr("none.stl")));
  EXPECT_THAT(mistakes("set: {motion.plunge.depth_mm: 1}\nvary: [{motion.plunge.depth_mm: [2]}]\n"),
              HasSubstr("is given twice in the study"));
  EXPECT_THAT(mistakes("keep: [picture]\n"), HasSubstr("did you mean pictures?"));
  EXPECT_THAT(mistakes("table: none.csv\n"), AllOf(HasSubstr("table"), HasSubstr("none.csv")));
}

TEST_F(StudyReader, MistakesOfSamples) {
  const auto sample = [&](const std::string& text) { return mistakes("sample: {" + text + "}\n"); };
  EXPECT_THAT(sample("n: 3"), HasSubstr("sample.of: missing"));
  EXPECT_THAT(sample("n: 0, of: {cutting.normal_ratio: {normal: [1, 1]}}"), HasSubstr("expected a whole number, 1 to"));
  EXPECT_THAT(sample("method: sobl, n: 3, of: {cutting.normal_ratio: {normal: [1, 1]}}"),
              HasSubstr("did you mean sobol?"));
  EXPECT_THAT(sample("n: 3, of: {cutting.normal_ratio: {gauss: [1, 1]}}"), HasSubstr("unknown distribution"));
  EXPECT_THAT(sample("n: 3, of: {cutting.normal_ratio: {normal: [1, 0]}}"), HasSubstr("standard deviation above 0"));
  EXPECT_THAT(sample("n: 3, of: {cutting.normal_ratio: {uniform: [1, 1]}}"), HasSubstr("lower end first"));
  EXPECT_THAT(sample("n: 3, of: {cutting.normal_ratio: {tilt_sd_deg: 1}}"), HasSubstr("does not fit this key"));
  EXPECT_THAT(sample("n: 3, of: {motion.plunge.axis: {normal: [1, 1]}}"), HasSubstr("does not fit this key"));
}

TEST_F(StudyReader, MistakesOfTablesNameTheirLine) {
  const auto table = [&](const std::string& text) {
    write("cohort.csv", text);
    return mistakes("table: cohort.csv\n");
  };
  EXPECT_THAT(table(""), HasSubstr("is empty"));
  EXPECT_THAT(table("bone.voxel_mm\n"), HasSubstr("has no rows"));
  EXPECT_THAT(table("label\nx\n"), HasSubstr("no column is a scenario key"));
  EXPECT_THAT(table("bone.voxel\n0.5\n"), AllOf(HasSubstr(":1: bone.voxel: unknown key"), HasSubstr("voxel_mm")));
  EXPECT_THAT(table("bone.voxel_mm,bone.voxel_mm\n1,1\n"), HasSubstr("a column given twice"));
  EXPECT_THAT(table("bone.voxel_mm,label\n\n\"1\n"), HasSubstr("a quotation mark that is not closed"));
  EXPECT_THAT(table("label;bone.voxel_mm\na;0,5\n"), AllOf(HasSubstr(":1:"), HasSubstr("semicolons separate")));
  EXPECT_THAT(table("label\tbone.voxel_mm\na\t0.5\n"), HasSubstr("tabulators separate"));
  EXPECT_THAT(table("label,bone.voxel_mm\na;0.5\n"), AllOf(HasSubstr(":2:"), HasSubstr("semicolons separate")));
  EXPECT_THAT(table("bone.voxel_mm,label\n,\n , \n"), HasSubstr("has no rows"));
  EXPECT_THAT(table("bone.voxel_mm,label\n0.5,a\n0.5\n"),
              AllOf(HasSubstr(":3:"), HasSubstr("found 1 cells; expected 2")));
}

TEST_F(StudyReader, AFileThatIsNoStudyIsRefused) {
  write("study.yaml", "- 1\n");
  EXPECT_THROW(read_study(path("study.yaml")), InputError);
  write("study.yaml", "");
  EXPECT_THROW(read_study(path("study.yaml")), InputError);
  EXPECT_THROW(read_study(path("none.yaml")), InputError);
  write("study.yaml", "version: 2\nbase: base.yaml\n");
  EXPECT_THROW(read_study(path("study.yaml")), InputError);
}

}  // namespace
}  // namespace reamsim::test
