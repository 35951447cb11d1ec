// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Scripts for batch systems: what they hold, and that no name breaks out of its quotes.
#include "sim/study/submit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/support/temp_dir.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// Every character that means something to a shell, Python or GNU parallel.
const std::string kHostile = "/a b/it's \"$(touch owned)\" `x` {} {1} \\ ; & # % * ~\n!";

Submission example() {
  return {.name = "my study",
          .program = "/usr/bin/reamsim",
          .study = "/s/my study.yaml",
          .output = "/out/my study",
          .overrides = {"engine.device=serial"},
          .shards = 4,
          .jobs = 2,
          .time_limit = "01:02:03"};
}

std::string text_of(BatchSystem system, const Submission& submission, std::size_t file = 0) {
  return submission_scripts(system, submission).files.at(file).text;
}

std::string read_all(const std::string& path) {
  std::ostringstream out;
  out << std::ifstream(path, std::ios::binary).rdbuf();
  return out.str();
}

void write_text(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

int shell(const std::string& command) {
  return std::system(command.c_str());
}

/// A program that writes its arguments, each ended by a line "|".
std::string recorder(const TempDir& dir) {
  const std::string path = dir.path() + "/it's a recorder";
  write_text(path, "#!/bin/sh\nprintf '%s\\n|\\n' \"$@\" >> " + shell_word(dir.path() + "/arguments") + "\n");
  shell("chmod +x " + shell_word(path));
  return path;
}

std::string recorded(const std::vector<std::string>& arguments) {
  std::string out;
  for (const std::string& argument : arguments) out += argument + "\n|\n";
  return out;
}

TEST(Submit, SlurmArrayRequeuesWhatIsInterrupted) {
  const std::string text = text_of(BatchSystem::slurm, example());
  EXPECT_THAT(text, AllOf(HasSubstr("#SBATCH --array=1-4\n"), HasSubstr("--cpus-per-task=2\n"),
                          HasSubstr("#SBATCH --time=01:02:03\n"), HasSubstr("#SBATCH --signal=B:USR1@60\n"),
                          HasSubstr("#SBATCH --job-name=my_study\n"), HasSubstr("--shard \"$1/4\" --jobs 2"),
                          HasSubstr("scontrol requeue \"${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID\"")));
  EXPECT_EQ(submission_scripts(BatchSystem::slurm, example()).files[1].path, "my_study.collect.sbatch");
}

TEST(Submit, SnakemakeStopsBeforeTheTimeLimit) {
  const std::string text = text_of(BatchSystem::snakemake, example());
  EXPECT_THAT(text, AllOf(HasSubstr("-s USR1 3663 "), HasSubstr("--shard {wildcards.shard}/4\""),
                          HasSubstr("resources: time=\"01:02:03\""), HasSubstr("threads: 2")));
  EXPECT_THAT(text_of(BatchSystem::snakemake, example(), 1), HasSubstr("restart-times: 5\n"));
}

TEST(Submit, EveryShellScriptIsValid) {
  const TempDir dir;
  Submission submission = example();
  submission.program = submission.study = submission.output = submission.name = kHostile;
  submission.overrides = {kHostile, kHostile};
  int scripts = 0;
  for (const BatchSystem system : {BatchSystem::slurm, BatchSystem::snakemake, BatchSystem::parallel}) {
    for (const SubmissionFile& file : submission_scripts(system, submission).files) {
      EXPECT_TRUE(is_submission_text(file.text)) << file.path;
      if (!file.text.starts_with("#!")) continue;
      write_text(dir.path() + "/script", file.text);
      EXPECT_EQ(shell("bash -n " + shell_word(dir.path() + "/script")), 0) << file.text;
      ++scripts;
    }
  }
  EXPECT_EQ(scripts, 4);
}

TEST(Submit, NamesReachTheProgramUnchanged) {
  const TempDir dir;
  Submission submission = example();
  submission.program = recorder(dir);
  submission.study = submission.output = kHostile;
  submission.overrides = {kHostile};
  write_text(dir.path() + "/script", text_of(BatchSystem::slurm, submission));
  ASSERT_EQ(shell("cd " + shell_word(dir.path()) + " && SLURM_ARRAY_TASK_ID=3 bash ./script"), 0);
  EXPECT_EQ(read_all(dir.path() + "/arguments"),
            recorded({"sweep", "run", kHostile, "-o", kHostile, "--shard", "3/4", "--jobs", "2", "--set", kHostile}));
  EXPECT_FALSE(std::filesystem::exists(dir.path() + "/owned"));
}

/// The shard ends with 75 after USR1, as `sweep run` does, and the script requeues its own array task.
TEST(Submit, SlurmScriptForwardsTheSignal) {
  const TempDir dir;
  Submission submission = example();
  submission.program = dir.path() + "/shard";
  write_text(submission.program, "#!/bin/bash\ntrap 'exit 75' USR1\ntouch started\nwhile :; do sleep 0.05; done\n");
  write_text(dir.path() + "/scontrol", "#!/bin/sh\necho \"$@\" > requeued\n");
  write_text(dir.path() + "/script", text_of(BatchSystem::slurm, submission));
  ASSERT_EQ(
      shell("cd " + shell_word(dir.path()) +
            " && chmod +x shard scontrol && export PATH=\"$PWD:$PATH\" SLURM_ARRAY_JOB_ID=7 SLURM_ARRAY_TASK_ID=2\n"
            "bash ./script & while [ ! -e started ]; do sleep 0.05; done\n"
            "kill -USR1 $!; wait $!; [ $? -eq 75 ]"),
      0);
  EXPECT_EQ(read_all(dir.path() + "/requeued"), "requeue 7_2\n");
}

/// A signal that comes before the program handles it ends the program, and the task is requeued as well.
TEST(Submit, SlurmScriptRequeuesAfterAnEarlySignal) {
  const TempDir dir;
  Submission submission = example();
  submission.program = dir.path() + "/shard";
  write_text(submission.program, "#!/bin/bash\nkill -USR1 $$\n");
  write_text(dir.path() + "/scontrol", "#!/bin/sh\necho \"$@\" > requeued\n");
  const std::string script = text_of(BatchSystem::slurm, submission);
  EXPECT_LT(script.find("trap "), script.find("& shard=$!")) << "the script itself is not ended by it";
  write_text(dir.path() + "/script", script);
  EXPECT_NE(shell("cd " + shell_word(dir.path()) +
                  " && chmod +x shard scontrol && export PATH=\"$PWD:$PATH\" SLURM_ARRAY_JOB_ID=7 "
                  "SLURM_ARRAY_TASK_ID=2\nbash ./script"),
            0);
  EXPECT_EQ(read_all(dir.path() + "/requeued"), "requeue 7_2\n");
}

TEST(Submit, PythonReadsItsLiterals) {
  const TempDir dir;
  write_text(dir.path() + "/p.py", "import sys\nsys.stdout.write(" + python_literal(kHostile) + ")\n");
  ASSERT_EQ(shell("cd " + shell_word(dir.path()) + " && python3 p.py > out"), 0);
  EXPECT_EQ(read_all(dir.path() + "/out"), kHostile);
}

TEST(Submit, NamesOfFilesArePlain) {
  EXPECT_EQ(plain_name("my study/ä"), "my_study___");
  EXPECT_EQ(plain_name("-x.y"), "_-x.y");
  EXPECT_EQ(plain_name("../x"), "_._x");
  EXPECT_THAT(plain_name(kHostile), Not(HasSubstr("/")));
}

TEST(Submit, TimeLimits) {
  EXPECT_EQ(seconds_of_time_limit("01:02:03"), 3723);
  EXPECT_EQ(seconds_of_time_limit("100:00:00"), 360000);
  for (const char* wrong : {"", "1", "01:02", "01:60:00", "01:00:60", "01:00:00x", "-1:00:00", "1:2:3:4"}) {
    EXPECT_EQ(seconds_of_time_limit(wrong), -1) << wrong;
  }
}

}  // namespace
}  // namespace reamsim::test
