// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/study_folder.h"

#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "sim/base/csv.h"
#include "sim/record/output_folder.h"
#include "tests/study/study_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

class Collect : public StudyTest {
 protected:
  Collect()
      : study_(study("vary: [{motion.plunge.depth_mm: [1, 2, 3, 4, -1]}]\n")),
        plan_(make_plan(study_)),
        runs_(identify_runs(study_, plan_)),
        folder_(study_, path("out")) {}

  /// A finished run with this summary.
  void finish(std::size_t run, const std::string& summary) const {
    const std::string dir = folder_.run_dir(runs_[run].id);
    std::filesystem::create_directories(dir);
    std::ofstream(dir + "/summary.json") << summary;
    std::ofstream(dir + "/scenario.yaml") << "version: 2\n";
    write_manifest(dir, {.kind = "run", .files = {"scenario.yaml", "summary.json"}});
  }
  /// The lines of runs.csv.
  [[nodiscard]] std::vector<std::string> table(StudyCounts& counts) const {
    counts = collect_runs(folder_, plan_, runs_).counts;
    std::istringstream text(file_bytes(path("out/runs.csv")));
    std::vector<std::string> lines;
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
  }

  Study study_;
  StudyPlan plan_;
  std::vector<IdentifiedRun> runs_;
  StudyFolder folder_;
};

TEST_F(Collect, HasARowForEveryRun) {
  finish(0, R"({"a": 1.5, "metrics": {"b": [2, null], "c": "text"}, "timings_s": {"load": 1}, "memory_mb": {"x": 1}})");
  finish(1, R"({"a": null, "metrics": {"d": 1e5}})");
  folder_.note_failure(runs_[2].id, "the disk, \"full\"");
  StudyCounts counts;
  const std::vector<std::string> lines = table(counts);
  ASSERT_EQ(lines.size(), 6U);
  EXPECT_EQ(lines[0], "run,id,status,message,motion.plunge.depth_mm,a,metrics.b.0,metrics.d");
  EXPECT_EQ(lines[1], "1," + runs_[0].id + ",done,,1,1.5,2,");
  EXPECT_EQ(lines[2], "2," + runs_[1].id + ",done,,2,,,100000");
  EXPECT_EQ(lines[3], "3," + runs_[2].id + ",failed,\"the disk, \"\"full\"\"\",3,,,");
  EXPECT_EQ(lines[4], "4," + runs_[3].id + ",missing,,4,,,");
  EXPECT_THAT(lines[5], HasSubstr("5,,failed,"));
  EXPECT_THAT(lines[5], HasSubstr("motion.plunge.depth_mm"));
  EXPECT_EQ(counts.done, 2);
  EXPECT_EQ(counts.failed, 2);
  EXPECT_EQ(counts.missing, 1);
}

TEST_F(Collect, TheTableHasTheRunsOfTheFile) {
  finish(0, R"({"a": 1.5, "motion": {"plunge": {"depth_mm": 7}}})");
  finish(1, R"({"a": null, "b": 2})");
  folder_.note_failure(runs_[2].id, "full");
  const RunTable table = collect_runs(folder_, plan_, runs_).table;
  EXPECT_THAT(table.parameters, ::testing::ElementsAre("motion.plunge.depth_mm"));
  EXPECT_THAT(table.results, ::testing::ElementsAre("a", "b")) << "a result with the name of a parameter is none";
  ASSERT_EQ(table.runs.size(), 5U);
  EXPECT_EQ(table.runs[0].numbers[0], 1.5);
  EXPECT_TRUE(std::isnan(table.runs[0].numbers[1]));
  EXPECT_EQ(table.runs[1].numbers[1], 2);
  EXPECT_EQ(table.runs[2].message, "full");
  EXPECT_FALSE(table.runs[0].has_report);
  const RunTable part = collect_runs(folder_, plan_, runs_, 2).table;
  EXPECT_EQ(part.runs.size(), 2U);
  EXPECT_EQ(part.all, 5U);
}

TEST_F(Collect, TheMessageOfAFinishedRunHasItsWarnings) {
  finish(0, R"({"a": 1, "warnings": ["removed bone, at once", "normal"]})");
  finish(1, R"({"a": 2, "warnings": ["normal"]})");
  finish(2, R"({"a": 3, "warnings": []})");
  const CollectedStudy found = collect_runs(folder_, plan_, runs_);
  EXPECT_EQ(found.table.runs[0].message, "removed bone, at once; normal");
  EXPECT_EQ(found.table.runs[2].message, "");
  EXPECT_EQ(found.warnings.runs(), 2);
  EXPECT_THAT(found.warnings.lines(),
              ::testing::ElementsAre("run 1: removed bone, at once", "run 1 and 1 more: normal"));
  EXPECT_EQ(found.warnings.lines(1).size(), 1U);
  EXPECT_THAT(file_bytes(path("out/runs.csv")), HasSubstr(",done,\"removed bone, at once; normal\",1,1"));
}

TEST_F(Collect, RowsOfTheSameRunAreFound) {
  std::vector<IdentifiedRun> runs;
  for (const char* id : {"a", "b", "a", "", "", "a", "b", "c"}) runs.push_back({id, ""});
  EXPECT_THAT(same_runs(runs), ::testing::ElementsAre("runs 1, 3 and 6 are the same run, which is simulated once",
                                                      "runs 2 and 7 are the same run, which is simulated once"));
  EXPECT_THAT(rows_of_run(runs, 1), ::testing::ElementsAre(1, 6));
  runs.assign(9, {"a", ""});
  EXPECT_THAT(same_runs(runs), ::testing::ElementsAre(HasSubstr("runs 1, 2, 3, 4, 5 and 4 more are")));
}

TEST_F(Collect, ADamagedResultIsNotDone) {
  finish(0, R"({"a": 1})");
  const std::string dir = folder_.run_dir(runs_[0].id);
  EXPECT_EQ(folder_.state(runs_[0].id), RunState::done);
  for (const std::uintmax_t bytes : {5U, 0U}) {
    std::filesystem::resize_file(dir + "/summary.json", bytes);
    EXPECT_EQ(folder_.state(runs_[0].id), RunState::missing);
  }
  finish(0, R"({"a": 1})");
  std::filesystem::resize_file(dir + "/scenario.yaml", 0);
  EXPECT_EQ(folder_.state(runs_[0].id), RunState::missing);
  finish(0, R"({"a": 1})");
  std::filesystem::remove(dir + "/manifest.json");
  EXPECT_EQ(folder_.state(runs_[0].id), RunState::missing);
}

TEST_F(Collect, ARunThatLacksWhatTheStudyKeepsIsNotDone) {
  finish(0, R"({"a": 1})");
  const StudyFolder keeps_forces(study("vary: [{motion.plunge.depth_mm: [1]}]\nkeep: [forces]\n"), path("out"));
  EXPECT_EQ(keeps_forces.state(runs_[0].id), RunState::missing);
}

TEST_F(Collect, AnotherFolderIsNoStudy) {
  std::filesystem::create_directory(path("mine"));
  write("mine/thesis.txt", "x");
  EXPECT_THROW(StudyFolder(study_, path("mine")), InputError);
  EXPECT_THROW(StudyFolder::open(study_, path("none")), InputError);
  EXPECT_THROW(StudyFolder(study_, path("base.yaml")), InputError);
  EXPECT_TRUE(std::filesystem::exists(path("mine/thesis.txt")));
}

/// Shards of a study begin at the same time, in a folder that does not exist.
TEST_F(Collect, ManyCreateTheFolderAtOnce) {
  for (int round = 0; round < 50; ++round) {
    std::atomic<int> refused = 0;
    std::vector<std::thread> shards;
    for (int i = 0; i < 4; ++i) {
      shards.emplace_back([&, round] {
        try {
          const StudyFolder folder(study_, path("at once " + std::to_string(round)));
        } catch (const std::exception&) {
          ++refused;
        }
      });
    }
    for (std::thread& shard : shards) shard.join();
    ASSERT_EQ(refused, 0) << "round " << round;
  }
}

}  // namespace
}  // namespace reamsim::test
