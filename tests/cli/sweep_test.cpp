// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Studies: one command simulates what is missing, whatever happened before.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/base/text.h"
#include "tests/cli/sweep_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

TEST_F(Sweep, OneCommandSimulatesAndCollects) {
  const ProgramResult result = sweep({"run", "study.yaml", "-o", "out", "--jobs", "2"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("4 runs: 4 done"));
  EXPECT_EQ(finished("out"), 4);
  const std::vector<std::string> table = lines("out/runs.csv");
  ASSERT_EQ(table.size(), 5U);
  EXPECT_THAT(table[0], HasSubstr("run,id,status,message,motion.plunge.depth_mm,cutting.specific_energy_j_mm3,"));
  EXPECT_THAT(table[0], HasSubstr(",removed_mm3,"));
  for (const char* file : {"effects.csv", "effects.png", "effects.svg", "effects.pdf", "effects.py", "sweep.html"}) {
    EXPECT_TRUE(exists(std::string("out/") + file)) << file;
  }
  EXPECT_THAT(result.out, HasSubstr("page: " + path("out") + "/sweep.html"));
  EXPECT_THAT(result.out, AllOf(HasSubstr("Plunge"), HasSubstr(" 4 done")));  // a row for each run
  std::istringstream printed(result.out);
  for (std::string line; std::getline(printed, line);) {
    const bool has_path = line.find('/') != std::string::npos;
    EXPECT_TRUE(has_path || text_width(line) <= 100) << line;
  }
  EXPECT_THAT(sweep({"status", "study.yaml", "-o", "out"}).out, HasSubstr("4 runs: 4 done, 0 failed"));
  // A shard collects nothing, which takes longer than these runs.
  const ProgramResult again = sweep({"run", "study.yaml", "-o", "out", "--shard", "1/1"});
  EXPECT_THAT(again.out, HasSubstr("0 to simulate"));
  // A larger study simulates what is new.
  write("study.yaml", with(kStudy, "n: 2", "n: 3"));
  EXPECT_THAT(sweep({"run", "study.yaml", "-o", "out", "--shard", "1/1"}).out, HasSubstr("2 to simulate"));
}

TEST_F(Sweep, ResultsOfAnotherPlanAreNamed) {
  const auto call = [&](const std::string& command, std::vector<std::string> more) {
    more.insert(more.begin(), {command, "study.yaml", "-o", "out"});
    return sweep(std::move(more));
  };
  const std::vector<std::string> set{"--set", "motion.plunge.feed_mm_s=10", "--set", "bone.voxel_mm=1"};
  std::vector<std::string> uncollected = set;
  uncollected.insert(uncollected.end(), {"--shard", "1/1"});
  ASSERT_EQ(call("run", uncollected).status, 0);
  for (const char* command : {"status", "collect"}) {
    const ProgramResult same = call(command, set);
    EXPECT_THAT(same.out, HasSubstr("4 runs: 4 done"));
    EXPECT_EQ(same.err, "") << command;
    const ProgramResult other = call(command, {});
    EXPECT_EQ(other.status, 0);
    EXPECT_THAT(other.out, HasSubstr("4 missing"));
    EXPECT_EQ(other.err, "reamsim: warning: 4 results in " + path("out") +
                             "/runs belong to another plan of this study: bone.voxel_mm is 1 there and 0.5 in this "
                             "plan, motion.plunge.feed_mm_s is 10 there and 5 in this plan; give the same --set as for "
                             "sweep run, or the same study\n")
        << command;
  }
  // Runs that the study no longer has explain nothing where none is missing.
  write("study.yaml", with(kStudy, "[0.5, 1]", "[1]"));
  EXPECT_EQ(call("status", set).err, "");
}

TEST_F(Sweep, ALogSaysAtOnceThatAStudyTakesLong) {
  write("study.yaml", with(kStudy, "n: 2", "n: 1024"));
  const ProgramResult result =
      sweep({"run", "study.yaml", "-o", "out", "--jobs", "1"}, [&] { return finished("out") > 2; });
  EXPECT_EQ(result.status, 75) << result.err;
  EXPECT_THAT(result.out, HasSubstr("\nsweep 1/2048 runs, "));
}

TEST_F(Sweep, ARunHasTheForcesOfReamsimRun) {
  ASSERT_EQ(sweep({"run", "study.yaml", "-o", "out"}).status, 0);
  const std::string row = lines("out/runs.csv")[4];  // 4,ID,done,,1,ENERGY,...
  std::istringstream cells(row);
  std::vector<std::string> cell(6);
  for (std::string& text : cell) std::getline(cells, text, ',');
  const ProgramResult alone =
      reamsim({.arguments = {"run", "s.yaml", "-o", "alone", "--set", "motion.plunge.depth_mm=" + cell[4], "--set",
                             "cutting.specific_energy_j_mm3=" + cell[5]},
               .environment = {},
               .folder = "",
               .interrupt_when = {}});
  ASSERT_EQ(alone.status, 0) << alone.err;
  EXPECT_EQ(read("out/runs/" + cell[1] + "/forces.csv"), read("alone/forces.csv"));
}

TEST_F(Sweep, AnInterruptedStudyGoesOnAndEndsTheSame) {
  // Runs of a second, so that each signal finds one at work.
  write("s.yaml", with(with(read("s.yaml"), "feed_mm_s: 5", "feed_mm_s: 0.02"), "engine:\n  device: serial\n",
                       "engine:\n  batch_frames: 10\n  device: serial\noutput:\n  checkpoint_s: 0.05\n"));
  ASSERT_EQ(sweep({"run", "study.yaml", "-o", "whole", "--jobs", "2"}).status, 0);
  for (const int signal : {SIGTERM, SIGKILL}) {
    const std::ptrdiff_t before = finished("out");
    const ProgramResult result = sweep(
        {"run", "study.yaml", "-o", "out", "--jobs", "2"}, [&] { return finished("out") > before; }, signal);
    if (signal == SIGTERM) {
      EXPECT_EQ(result.status, 75) << result.err;  // of an interrupted command that can continue
      EXPECT_THAT(result.err, HasSubstr("interrupted; the same command continues"));
    }
  }
  ProgramResult result;
  for (int attempt = 0; attempt < 20; ++attempt) {  // workers of the killed command may not have ended yet
    result = sweep({"run", "study.yaml", "-o", "out", "--jobs", "2"});
    if (result.out.find("4 done") != std::string::npos) break;
  }
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(read("out/runs.csv"), read("whole/runs.csv"));
  EXPECT_EQ(finished("out"), 4);
}

TEST_F(Sweep, ShardsMakeTheWholeStudy) {
  ASSERT_EQ(sweep({"run", "study.yaml", "-o", "whole"}).status, 0);
  for (const char* shard : {"1/3", "2/3", "3/3"}) {
    const ProgramResult result = sweep({"run", "study.yaml", "-o", "out", "--shard", shard});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_FALSE(exists("out/runs.csv"));
  }
  EXPECT_EQ(sweep({"collect", "study.yaml", "-o", "out"}).status, 0);
  EXPECT_EQ(read("out/runs.csv"), read("whole/runs.csv"));
  // No numbers of 32 bits: the first would be 1/1, the second 1/1 as well.
  for (const std::string wrong :
       {"-4294967295/1", "4294967297/1", "4/3", "0/3", "1/", "1/3/3", "1/18446744073709551616"}) {
    const ProgramResult result = sweep({"run", "study.yaml", "-o", "out", "--shard=" + wrong});
    EXPECT_EQ(result.status, 2) << wrong;
    EXPECT_THAT(result.err, HasSubstr("--shard: found " + wrong + "; expected i/n"));
  }
}

TEST_F(Sweep, AShardOfMoreThan32BitsHasNoRunOfAnother) {
  const ProgramResult last = sweep({"run", "study.yaml", "-o", "out", "--shard", "4294967298/4294967298"});
  EXPECT_EQ(last.status, 0) << last.err;
  EXPECT_EQ(finished("out"), 0);
  const ProgramResult first = sweep({"run", "study.yaml", "-o", "out", "--shard", "1/4294967297"});
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_EQ(finished("out"), 1);
}

TEST_F(Sweep, AFailingRunIsOneRow) {
  // A depth that is no number is known from the scenario; a tool that starts below the block only from the scene.
  write("study.yaml",
        "version: 1\nbase: s.yaml\nset: {motion.plunge.from: contact}\nvary:\n"
        "  - zip: {motion.plunge.depth_mm: [0.5, deep, 0.5], motion.plunge.entry_mm: [[0, 0, 0], [0, 0, 0], [900, 0, "
        "0]]}\n");
  const ProgramResult plan = sweep({"plan", "study.yaml"});
  EXPECT_EQ(plan.status, 2);
  EXPECT_THAT(plan.err, AllOf(HasSubstr("run 2"), HasSubstr("run 3"), HasSubstr("2 of 3 runs are wrong")));
  const ProgramResult result = sweep({"run", "study.yaml", "-o", "out"});
  EXPECT_EQ(result.status, 1);
  EXPECT_THAT(result.err,
              AllOf(HasSubstr("2 runs failed; the others are complete; correct the input that the messages"),
                    Not(HasSubstr("repeats those that failed"))))
      << "they would fail again";
  const std::vector<std::string> table = lines("out/runs.csv");
  ASSERT_EQ(table.size(), 4U);
  EXPECT_THAT(table[1], HasSubstr(",done,"));
  EXPECT_THAT(table[2], AllOf(HasSubstr("2,,failed,"), HasSubstr("motion.plunge.depth_mm")));
  EXPECT_THAT(table[3], AllOf(HasSubstr(",failed,"), HasSubstr("motion.plunge.entry_mm")));
  EXPECT_THAT(read("out/sweep.html"), HasSubstr("motion.plunge.depth_mm"));
  EXPECT_FALSE(exists("out/effects.png")) << "one run has no effects";
  const ProgramResult collected = sweep({"collect", "study.yaml", "-o", "out"});
  EXPECT_EQ(collected.status, 0);
  EXPECT_THAT(collected.err, AllOf(HasSubstr("run 2"), HasSubstr("run 3")));
}

TEST_F(Sweep, WarningsOfFinishedRunsAreShown) {
  // A tool that begins inside the block removes bone at once, without force.
  write("study.yaml",
        "version: 1\nbase: s.yaml\nset: {motion.plunge.approach_mm: 0}\nvary:\n"
        "  - motion.plunge.entry_mm: [[0, 0, 0], [0, 0, -1]]\n");
  const auto named = AllOf(HasSubstr("of 2 runs have warnings"), HasSubstr("reamsim: warning: run "));
  EXPECT_THAT(sweep({"plan", "study.yaml"}).err, named);
  for (const char* command : {"run", "collect"}) {
    const ProgramResult result = sweep({command, "study.yaml", "-o", "out"});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_THAT(result.err, AllOf(HasSubstr("1 of 2 finished runs have warnings; the column message of runs.csv"),
                                  HasSubstr("reamsim: warning: run 2: ")));
  }
  const ProgramResult status = sweep({"status", "study.yaml", "-o", "out"});
  EXPECT_EQ(status.status, 0);
  EXPECT_THAT(status.err, AllOf(HasSubstr("1 of 2 finished runs have warnings; `reamsim sweep collect` writes all"),
                                HasSubstr("reamsim: warning: run 2: ")));
  const std::vector<std::string> table = lines("out/runs.csv");
  const std::string id = table[2].substr(2, 16);
  const auto summary = nlohmann::json::parse(read("out/runs/" + id + "/summary.json"));
  const std::string warning = summary["warnings"][0];
  EXPECT_THAT(table[1], HasSubstr(",done,,"));
  EXPECT_THAT(table[2], AllOf(HasSubstr(",done,"), HasSubstr(warning.substr(0, 30))));
}

TEST_F(Sweep, RowsOfTheSameRunCountEach) {
  write("cohort.csv",
        "motion.plunge.depth_mm,motion.plunge.entry_mm\n0.5,\n0.5,\"[900, 0, 0]\"\n0.5,\n0.5,\"[900, 0, 0]\"\n");
  write("study.yaml", "version: 1\nbase: s.yaml\nset: {motion.plunge.from: contact}\ntable: cohort.csv\n");
  const ProgramResult result = sweep({"run", "study.yaml", "-o", "out"});
  EXPECT_EQ(result.status, 1);
  EXPECT_THAT(result.out, AllOf(HasSubstr("runs 1 and 3 are the same run, which is simulated once"),
                                HasSubstr("runs 2 and 4 are the same run"), HasSubstr("4 runs: 2 done, 2 failed")));
  EXPECT_THAT(result.err, AllOf(HasSubstr("run 2 and 1 more: "), HasSubstr("2 runs failed; the others")));
  EXPECT_EQ(finished("out"), 1);
}

/// What /proc knows of a process; "" once it has ended.
std::string process_file(const std::string& process, const char* name) {
  std::ifstream file("/proc/" + process + "/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Ends a worker of `reamsim sweep run` that works in the folder, not the process in which it reads files. Returns
/// whether there was one.
bool kill_worker_in(const std::string& folder) {
  for (const fs::directory_entry& entry : fs::directory_iterator("/proc")) {
    const std::string process = entry.path().filename().string();
    std::error_code error;
    if (fs::read_symlink(entry.path() / "cwd", error) != folder || error) continue;
    if (process_file(process, "cmdline").find("worker") == std::string::npos) continue;
    const std::string stat = process_file(process, "stat");  // NUMBER (NAME) STATE PARENT ...
    const std::size_t end_of_name = stat.rfind(')');
    if (end_of_name == std::string::npos) continue;
    std::string state, parent;
    std::istringstream(stat.substr(end_of_name + 1)) >> state >> parent;
    if (process_file(parent, "cmdline").find("worker") != std::string::npos) continue;
    return kill(std::stoi(process), SIGKILL) == 0;
  }
  return false;
}

TEST_F(Sweep, AWorkerThatTheSystemEndsFailsItsRunOnly) {
  bool killed = false;
  const ProgramResult result = sweep({"run", "study.yaml", "-o", "out", "--jobs", "1"}, [&] {
    killed = killed || (finished("out") > 0 && is_running("out") && kill_worker_in(fs::canonical(dir_).string()));
    return false;
  });
  ASSERT_TRUE(killed);
  EXPECT_EQ(result.status, 1);
  const auto cause = AllOf(HasSubstr("its process was ended by signal 9"), HasSubstr("use fewer --jobs"));
  EXPECT_THAT(result.err, cause);
  EXPECT_THAT(result.out, HasSubstr("4 runs: 3 done, 1 failed, 0 interrupted"));
  EXPECT_THAT(read("out/runs.csv"), cause);
  const ProgramResult again = sweep({"run", "study.yaml", "-o", "out"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("4 runs: 4 done"));
}

TEST_F(Sweep, AMistakeInATableNamesItsLine) {
  write("cohort.csv", "label,motion.plunge.depth_mm\r\nP1,0.5\r\n,\r\nP2,\"0,7\"\r\n");
  write("study.yaml", "version: 1\nbase: s.yaml\ntable: cohort.csv\n");
  const ProgramResult plan = sweep({"plan", "study.yaml"});
  EXPECT_EQ(plan.status, 2);
  EXPECT_THAT(plan.err, AllOf(HasSubstr("run 2: "), HasSubstr("cohort.csv:4: "),
                              HasSubstr("motion.plunge.depth_mm: found the text"), HasSubstr("1 of 2 runs are wrong")));
  EXPECT_EQ(sweep({"run", "study.yaml", "-o", "out"}).status, 1);
  EXPECT_THAT(lines("out/runs.csv")[2], AllOf(HasSubstr("2,,failed,"), HasSubstr("cohort.csv:4: ")));
}

TEST_F(Sweep, AMissingFileInATableFailsItsRow) {
  write("cohort.csv", "label,tool.mesh,motion.plunge.depth_mm\nP1,,0.5\nP2,none.stl,0.5\nP3,,deep\n");
  write("study.yaml", "version: 1\nbase: s.yaml\ntable: cohort.csv\n");
  const ProgramResult plan = sweep({"plan", "study.yaml"});
  EXPECT_EQ(plan.status, 2);
  const auto named = AllOf(HasSubstr("run 2: "), HasSubstr("cohort.csv:3: tool.mesh: "), HasSubstr("none.stl"),
                           HasSubstr("run 3: "), HasSubstr("cohort.csv:4: "));
  EXPECT_THAT(plan.err, AllOf(named, HasSubstr("2 of 3 runs are wrong")));
  const ProgramResult result = sweep({"run", "study.yaml", "-o", "out"});
  EXPECT_EQ(result.status, 1);
  EXPECT_THAT(result.err, named);
  EXPECT_THAT(result.out, HasSubstr("3 runs: 1 done, 2 failed"));
  EXPECT_THAT(lines("out/runs.csv")[2],
              AllOf(HasSubstr("2,,failed,"), HasSubstr("cohort.csv:3: "), HasSubstr(",P2,none.stl,")));
}

TEST_F(Sweep, PlanWritesNothing) {
  const ProgramResult result = sweep({"plan", "study.yaml"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("4 runs of "), HasSubstr("time: about "), HasSubstr("memory: up to "),
                                HasSubstr("disk: about ")));
  EXPECT_FALSE(exists("out"));
}

TEST_F(Sweep, EstimatesCountTheForceBasis) {
  // It repeats the cut on the host, which takes several times as long as the simulation on the device.
  const auto estimate_s = [&](const std::string& basis) {
    write("study.yaml", "version: 1\nbase: " REAMSIM_ROOT
                        "/trajectories/default.yaml\n"
                        "set: {bone.voxel_mm: 0.5, motion.plunge.feed_mm_s: 0.05, output.force_basis: " +
                            basis + "}\n");
    double least_s = 1e9;  // of two: other programs only make an estimate longer
    for (int i = 0; i < 2; ++i) {
      const ProgramResult plan = sweep({"plan", "study.yaml", "--jobs", "1"});
      EXPECT_EQ(plan.status, 0) << plan.err;
      least_s = std::min(least_s, number_after(plan.out, "time: about "));
    }
    return least_s;
  };
  EXPECT_GT(estimate_s("true"), 1.3 * estimate_s("false"));
}

TEST_F(Sweep, AFolderWithSomethingElseIsLeftAlone) {
  fs::create_directory(path("out"));
  write("out/thesis.txt", "x");
  const ProgramResult result = sweep({"run", "study.yaml", "-o", "out"});
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.err, HasSubstr("is not the folder of a study"));
  EXPECT_EQ(read("out/thesis.txt"), "x");
  EXPECT_FALSE(exists("out/runs"));
}

TEST_F(Sweep, SubmitWritesScriptsAndNothingElse) {
  const auto submit = [this](std::vector<std::string> more) {
    more.insert(more.begin(), {"submit", "study.yaml", "-o", "out", "--to", "scripts"});
    return sweep(std::move(more));
  };
  const ProgramResult result = submit({"--slurm", "--shards", "4"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("sbatch --parsable ./study.sbatch"));
  EXPECT_THAT(read("scripts/study.sbatch"),
              AllOf(HasSubstr("--array=1-4"), HasSubstr("study='" + path("study.yaml") + "'")));
  EXPECT_TRUE(exists("scripts/study.collect.sbatch"));
  EXPECT_FALSE(exists("out"));
  EXPECT_EQ(submit({"--slurm"}).status, 2) << "exists";
  EXPECT_EQ(submit({"--slurm", "--overwrite"}).status, 0);
  EXPECT_EQ(submit({"--parallel", "--shards", "4"}).status, 0);
  EXPECT_EQ(submit({"--snakemake"}).status, 0);
  write("scripts/Snakefile", "mine\n");
  EXPECT_EQ(submit({"--snakemake", "--overwrite"}).status, 2) << "not its own file";
  EXPECT_EQ(read("scripts/Snakefile"), "mine\n");
  EXPECT_EQ(submit({}).status, 2) << "no system";
  EXPECT_EQ(submit({"--slurm", "--parallel"}).status, 2) << "two systems";
  EXPECT_THAT(submit({"--slurm", "--overwrite", "--shards", "9"}).err, HasSubstr("9 shards of 4 runs"));
  EXPECT_THAT(submit({"--slurm", "--overwrite", "--time-limit", "90"}).err, HasSubstr("--time-limit"));
}

}  // namespace
}  // namespace reamsim::test
