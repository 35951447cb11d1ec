// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <set>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/environment.h"
#include "cli/lab.h"
#include "cli/sweep.h"
#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim {

void SweepOptions::add_to(CLI::App& command) {
  command.add_option("STUDY", file, "Study file (YAML), or the name of a shipped one")
      ->required()
      ->transform(shipped<ShippedKind::study>, "");
  add_output(command, output, "Folder of the study (default: out/NAME)");
  add_overrides(command, overrides, "Override a key of every run, for example engine.device=serial");
}

void add_jobs(CLI::App& command, int& jobs) {
  jobs = static_cast<int>(std::max(1L, sysconf(_SC_NPROCESSORS_ONLN)));
  command
      .add_option("--jobs", jobs,
                  "Runs at a time, which divide the processors among them (default: one for each processor)")
      ->check(CLI::Range(1, 1024));
}

namespace {

/// Throws InputError where one of --devices does not exist, RunError where there is no OpenCL.
void check_devices(const SweepOptions& options, const Console& console) {
  for (const std::string& device : options.devices) {
    if (device.empty()) throw InputError({}, "--devices", "an empty name", "expected auto, serial, or parts of names");
    const auto kernels = prepare_opencl(device, console);
    if (device != "serial") cl::choose_device(device);
  }
}

void add_workers(CLI::App& command, SweepOptions& options) {
  add_jobs(command, options.jobs);
  command
      .add_option(
          "--devices", options.devices,
          "Devices in place of engine.device, among which the runs are divided: auto, serial, or parts of names")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("A,B");
}

/// Reads the study and parses the scenarios of all runs. Throws InputError for a wrong study.
SweepRuns load_sweep(const SweepOptions& options) {
  SweepRuns out;
  out.study = read_study(options.file);
  out.plan = make_plan(out.study, options.overrides);
  out.runs = identify_runs(out.study, out.plan, [](std::size_t) {
    if (stop_requested()) throw Interrupted();
  });
  return out;
}

/// Why scenarios are wrong, and with a folder why runs failed.
RunMessages failures_of(const SweepRuns& sweep, const StudyFolder* folder = nullptr) {
  RunMessages out;
  for (std::size_t i = 0; i < sweep.runs.size(); ++i) {
    const auto& [id, mistake] = sweep.runs[i];
    if (id.empty()) {
      out.add(sweep.plan.runs[i].number, {mistake});
    } else if (folder != nullptr && folder->state(id) == RunState::failed) {
      out.add(sweep.plan.runs[i].number, {folder->failure(id)});
    }
  }
  return out;
}

void print(const RunMessages& messages, const Console& console) {
  for (const std::string& line : messages.lines()) console.warn(line);
}

// --- plan ---

/// Sums of the estimates of runs.
struct StudyEstimate {
  double total_s = 0;
  double longest_s = 0;
  std::size_t largest_bytes = 0;
  std::int64_t frames = 0;
  RunMessages warnings;

  void add(int number, const RunEstimate& run) {
    total_s += run.load_s + run.simulate_s;
    longest_s = std::max(longest_s, run.load_s + run.simulate_s);
    largest_bytes = std::max(largest_bytes, run.memory_bytes);
    frames += run.frames;
    warnings.add(number, run.warnings);
  }
};

/// `runs`: at least one.
void print_estimate(const Console& console, const Study& study, const StudyEstimate& estimate, std::size_t runs,
                    int jobs) {
  const std::size_t parallel = std::min(static_cast<std::size_t>(jobs), runs);
  console.say(fmt::format("time: about {:.2g} s with --jobs {}, the longest run {:.2g} s{}",
                          estimate.total_s / static_cast<double>(parallel), jobs, estimate.longest_s,
                          study.keep.pictures ? ", plus pictures" : ""));
  console.say("memory: up to " + megabytes(estimate.largest_bytes) + " per job, " +
              megabytes(estimate.largest_bytes * parallel) + " in total");
  // Of the files of runs of the shipped scenarios. Grids and pictures are not estimated.
  constexpr std::size_t kSummaryBytes = 12'000, kFrameBytes = 230;
  const bool forces = study.keep.forces || study.keep.pictures;
  const std::size_t bytes =
      kSummaryBytes * runs + (forces ? kFrameBytes * static_cast<std::size_t>(estimate.frames) : 0);
  const std::string more = study.keep.grids || study.keep.pictures ? ", plus grids and pictures" : "";
  console.say("disk: about " + megabytes(bytes) + more);
}

void plan_command(const SweepOptions& options, const Console& console) {
  check_devices(options, console);
  const SweepRuns sweep = load_sweep(options);
  std::vector<std::size_t> valid;
  RunMessages mistakes = failures_of(sweep);
  for (std::size_t i = 0; i < sweep.runs.size(); ++i) {
    if (!sweep.runs[i].id.empty()) valid.push_back(i);
  }
  console.say(fmt::format("{}: {} runs of {}", sweep.study.name, sweep.runs.size(), sweep.study.base));
  for (const std::string& line : same_runs(sweep.runs)) console.say(line);
  StudyEstimate estimate;
  const auto answered = [&](const WorkerAnswer& answer) {
    if (answer.outcome == WorkerAnswer::Outcome::done) {
      estimate.add(sweep.plan.runs[answer.run].number, nlohmann::json::parse(answer.text).get<RunEstimate>());
    } else if (answer.has_failed()) {
      mistakes.add(sweep.plan.runs[answer.run].number, {answer.text});
    }
  };
  if (!work_on(sweep, valid, options, "", console, answered)) throw Interrupted();
  warn_of_runs(estimate.warnings, fmt::format("{} of {} runs have warnings", estimate.warnings.runs(), valid.size()),
               console);
  if (!valid.empty()) print_estimate(console, sweep.study, estimate, valid.size(), options.workers());
  print(mistakes, console);
  if (mistakes.runs() > 0) {
    refuse_file(options.file, fmt::format("{} of {} runs are wrong", mistakes.runs(), sweep.runs.size()),
                "correct the study or its scenario; the warnings above name the mistakes");
  }
}

// --- status, collect ---

/// Says where results of another plan explain runs that are missing.
void warn_of_other_plan(const SweepRuns& sweep, const StudyFolder& folder, const Console& console) {
  if (count_runs(folder, sweep.runs).missing == 0) return;
  const std::string others = text_of_other_runs(sweep.study, sweep.plan, sweep.runs, folder);
  if (!others.empty()) console.warn(others);
}

void status_command(const SweepOptions& options, const Console& console) {
  const SweepRuns sweep = load_sweep(options);
  const StudyFolder folder = StudyFolder::open(sweep.study, options.dir(sweep.study));
  const StudyCounts counts = count_runs(folder, sweep.runs);
  console.say(counts_text(counts));
  const RunMessages warnings = warnings_of_runs(folder, sweep.plan, sweep.runs);
  warn_of_runs(warnings,
               fmt::format("{} of {} finished runs have warnings; `reamsim sweep collect` writes all of them to the "
                           "column message of runs.csv",
                           warnings.runs(), counts.done),
               console);
  print(failures_of(sweep, &folder), console);
  warn_of_other_plan(sweep, folder, console);
}

void collect_command(const SweepOptions& options, const Console& console) {
  const SweepRuns sweep = load_sweep(options);
  const std::string dir = options.dir(sweep.study);
  keep_results_of_uq(options, dir);
  const StudyFolder folder = StudyFolder::open(sweep.study, dir);
  collect_and_show(sweep, folder, console);
  print(failures_of(sweep, &folder), console);
  warn_of_other_plan(sweep, folder, console);
}

// --- run ---

/// A part of the runs: those whose place among the different runs is i modulo n.
struct Shard {
  std::uint64_t index = 0, count = 1;
};

/// "2/8" is the second of eight. Throws InputError.
Shard parse_shard(const std::string& text) {
  if (text.empty()) return {};
  const std::vector<std::string> parts = split(text, '/');
  const std::uint64_t index = whole_number(parts.front()).value_or(0), count = whole_number(parts.back()).value_or(0);
  if (parts.size() != 2 || index < 1 || index > count) {
    throw InputError({}, "--shard", "found " + text, "expected i/n with i from 1 to n, for example 1/8");
  }
  return {index - 1, count};
}

/// The runs that are not done, each folder once.
std::vector<std::size_t> runs_to_do(const SweepRuns& sweep, const StudyFolder& folder, const Shard& shard) {
  std::vector<std::size_t> out;
  std::set<std::string> seen;
  for (std::size_t i = 0; i < sweep.runs.size(); ++i) {
    const std::string& id = sweep.runs[i].id;
    if (id.empty() || !seen.insert(id).second) continue;
    if ((seen.size() - 1) % shard.count != shard.index) continue;
    if (folder.state(id) != RunState::done) out.push_back(i);
  }
  return out;
}

/// Simulates what is missing.
class StudyRun {
 public:
  StudyRun(const SweepOptions& options, const Console& console)
      : options_(options),
        console_(console),
        shard_(parse_shard(options_.shard)),
        sweep_(load_sweep(options_)),
        folder_(folder_to_run()) {}

  SweepRuns run() {
    const std::vector<std::size_t> runs = runs_to_do(sweep_, folder_, shard_);
    if (options_.shard.empty()) require_lab();
    console_.say(fmt::format("{}: {} runs in the study, {} to simulate -> {}", sweep_.study.name, sweep_.runs.size(),
                             runs.size(), folder_.path()));
    for (const std::string& line : same_runs(sweep_.runs)) console_.say(line);
    if (shard_.index == 0) failures_ = failures_of(sweep_);
    wrong_ = failures_.runs();
    for (const std::size_t i : runs) folder_.forget_failure(sweep_.runs[i].id);
    const bool all =
        work_on(sweep_, runs, options_, folder_.path(), console_, [this](const WorkerAnswer& answer) { note(answer); });
    for (const std::string& line : continued_) console_.say(line);
    folder_.sync();
    if (!all) throw Suspended("interrupted; the same command continues");
    if (options_.shard.empty()) {
      Console console = console_;
      console.quiet = console.quiet || !options_.shows_table;
      collect_and_show(sweep_, folder_, console);
    } else {
      console_.say("results: " + folder_.path() + "; when all shards are done: reamsim sweep collect");
    }
    report();
    return std::move(sweep_);
  }

 private:
  StudyFolder folder_to_run() {
    check_devices(options_, console_);
    const std::string dir = options_.dir(sweep_.study);
    keep_results_of_uq(options_, dir);
    return {sweep_.study, dir};
  }

  void note(const WorkerAnswer& answer) {
    const int number = sweep_.plan.runs[answer.run].number;
    if (answer.has_failed()) {
      folder_.note_failure(sweep_.runs[answer.run].id, answer.text);
      // Each row that is this run, as runs.csv counts them.
      for (const std::size_t row : rows_of_run(sweep_.runs, answer.run)) {
        failures_.add(sweep_.plan.runs[row].number, {answer.text});
        wrong_ += answer.outcome == WorkerAnswer::Outcome::wrong_input ? 1 : 0;
      }
    }
    if (answer.outcome == WorkerAnswer::Outcome::busy) ++busy_;
    if (answer.outcome == WorkerAnswer::Outcome::done && !answer.text.empty()) {
      continued_.push_back(fmt::format("run {}: {}", number, answer.text));
    }
  }

  void report() const {
    if (busy_ > 0) console_.say(fmt::format("{} runs are being simulated by another process", busy_));
    print(failures_, console_);
    if (failures_.runs() > 0) {
      throw RunError(fmt::format("{} runs failed; the others are complete; {}", failures_.runs(), advice()));
    }
  }

  /// A run with wrong input fails again.
  [[nodiscard]] std::string advice() const {
    const std::string repeat = "the same command repeats those that failed";
    if (wrong_ == 0) return repeat;
    const std::string correct = "correct the input that the messages name, or the values of its key in the study";
    if (wrong_ == failures_.runs()) return correct + ": repeated as they are, they fail again";
    return fmt::format("for {} of them {}; {}", wrong_, correct, repeat);
  }

  const SweepOptions& options_;
  const Console& console_;
  Shard shard_;
  SweepRuns sweep_;
  StudyFolder folder_;
  RunMessages failures_;
  std::vector<std::string> continued_;  ///< which runs, after which frame
  int busy_ = 0;
  int wrong_ = 0;  ///< of the failures: those by wrong input
};

}  // namespace

SweepRuns simulate_study(const SweepOptions& options, const Console& console) {
  return StudyRun(options, console).run();
}

void add_sweep_command(CLI::App& app, Console& console) {
  auto* sweep = app.add_subcommand("sweep", "Simulate a study: many runs of one scenario from one file");
  sweep->require_subcommand(1);
  const auto add = [&](const char* name, const char* description, void (*call)(const SweepOptions&, const Console&)) {
    const auto added = add_command(*sweep, name, description, console, call);
    added.second->add_to(*added.first);
    return added;
  };
  const auto [plan, plan_options] =
      add("plan", "Validate every run and estimate time, memory and disk; write nothing", plan_command);
  add_workers(*plan, *plan_options);
  const auto [run, run_options] =
      add("run", "Simulate the runs that are not done yet, then collect them",
          [](const SweepOptions& options, const Console& to) { simulate_study(options, to); });
  add_workers(*run, *run_options);
  run->add_option("--shard", run_options->shard, "Simulate part i of n only, and collect nothing")->type_name("i/n");
  run->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  add("status", "Count finished, failed and missing runs", status_command);
  add("collect", "Write the table of runs, plots of main effects and a page to look at them", collect_command);
  add_sweep_submit(*sweep, console);
  add_sweep_worker(*sweep);
}

}  // namespace reamsim
