// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "cli/commands.h"
#include "cli/sweep.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/record/output_folder.h"
#include "sim/study/submit.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

constexpr int kDefaultShards = 10;
/// Shards save checkpoints 60 s before the limit.
constexpr int kLeastLimit_s = 120;

struct SubmitOptions {
  SweepOptions sweep;
  BatchSystem system = BatchSystem::parallel;
  int shards = 0;
  std::string time_limit = "01:00:00";
  std::string to;
  bool overwrite = false;
};

int shards_of(const SubmitOptions& options, std::size_t runs) {
  const int most = static_cast<int>(std::min<std::size_t>(runs, 1'000'000));
  if (options.shards > most) {
    throw InputError({}, "--shards", fmt::format("{} shards of {} runs", options.shards, runs),
                     "give at most as many shards as the study has runs");
  }
  return options.shards > 0 ? options.shards : std::min(kDefaultShards, most);
}

Submission submission_of(const SubmitOptions& options) {
  if (seconds_of_time_limit(options.time_limit) < kLeastLimit_s) {
    throw InputError({}, "--time-limit", "found " + options.time_limit,
                     "expected HH:MM:SS of at least 00:02:00, for example 01:00:00");
  }
  const Study study = read_study(options.sweep.file);
  const StudyPlan plan = make_plan(study, options.sweep.overrides);
  return {.name = study.name,
          .program = fs::read_symlink("/proc/self/exe").string(),
          .study = study.file,
          .output = fs::absolute(options.sweep.dir(study)).lexically_normal().string(),
          .overrides = options.sweep.overrides,
          .shards = shards_of(options, plan.runs.size()),
          .jobs = options.sweep.jobs,
          .time_limit = options.time_limit};
}

void submit_command(const SubmitOptions& options, const Console& console) {
  const Submission submission = submission_of(options);
  const SubmissionScripts scripts = submission_scripts(options.system, submission);
  const auto is_submission = [](const std::string& path) { return is_submission_text(read_file_start(path, 256)); };
  const auto path_of = [&](const SubmissionFile& file) { return options.to + "/" + file.path; };
  for (const SubmissionFile& file : scripts.files) {
    std::error_code error;
    fs::create_directories(fs::path(path_of(file)).parent_path(), error);
    if (error) fail_to_write(path_of(file));
    require_replaceable_file(path_of(file), "--to", options.overwrite, is_submission, {submission.study});
  }
  constexpr fs::perms kExecutable = fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec;
  for (const SubmissionFile& file : scripts.files) {
    std::error_code error;
    write_file(path_of(file), file.text);
    if (file.executable) fs::permissions(path_of(file), kExecutable, fs::perm_options::add, error);
    if (error) fail_to_write(path_of(file));
    console.say("wrote " + path_of(file));
  }
  console.say("start with:");
  console.say("  cd " + shell_word(options.to));
  for (const std::string& line : scripts.start) console.say("  " + line);
}

}  // namespace

void add_sweep_submit(CLI::App& sweep, Console& console) {
  const auto [command, options] = add_command(
      sweep, "submit", "Write scripts that run the study on a cluster; start nothing", console, submit_command);
  options->sweep.add_to(*command);
  auto* system = command->add_option_group("system");
  const auto add = [system, into = options](const char* flag, BatchSystem chosen, const char* description) {
    return system->add_flag_callback(
        flag, [into, chosen] { into->system = chosen; }, description);
  };
  add("--slurm", BatchSystem::slurm, "A Slurm job array, which is requeued before its time limit");
  add("--snakemake", BatchSystem::snakemake, "A Snakemake 7 workflow with a profile for Slurm");
  auto* parallel = add("--parallel", BatchSystem::parallel, "A script of GNU parallel for one machine");
  system->require_option(1);
  command->add_option("--shards", options->shards, "Parts of the study (default: 10, at most a run each)")
      ->check(CLI::Range(1, 1'000'000));
  command->add_option("--jobs", options->sweep.jobs, "Runs at a time, and processors, of a shard (default: 1)")
      ->check(CLI::Range(1, 1024));
  command
      ->add_option("--time-limit", options->time_limit,
                   "Time limit of a shard (default: 01:00:00); 60 s before it checkpoints are saved")
      ->type_name("HH:MM:SS")
      ->excludes(parallel);
  add_path_option(*command, "--to", options->to, "Folder for the scripts", "DIR")->required();
  command->add_flag("--overwrite", options->overwrite, "Replace scripts of an earlier submit");
}

}  // namespace reamsim
