// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <sched.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <vector>

#include "cli/console.h"
#include "cli/environment.h"
#include "cli/outputs.h"
#include "cli/sweep.h"
#include "cli/sweep_estimate.h"
#include "cli/sweep_workers.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/record/output_folder.h"
#include "sim/study/study_folder.h"

namespace reamsim {

namespace {

/// The arguments of a worker, which SweepWorkers gives it.
struct WorkerOptions {
  SweepOptions sweep;
  std::string part;  ///< "i/n": its part of the processors
  bool check = false;
};

/// Leaves this process its part of the processors it may use.
void take_processors(const std::string& part) {
  const std::vector<std::string> parts = split(part, '/');
  const int index = static_cast<int>(whole_number(parts.front()).value_or(0));
  const int count = static_cast<int>(whole_number(parts.back()).value_or(0));
  if (count < 2) return;
  cpu_set_t all, own;
  if (sched_getaffinity(0, sizeof all, &all) != 0) return;
  CPU_ZERO(&own);
  const int processors = CPU_COUNT(&all);
  for (int cpu = 0, k = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(cpu, &all) == 0) continue;
    if (k * count / processors == index || (processors < count && k == index % processors)) CPU_SET(cpu, &own);
    ++k;
  }
  if (CPU_COUNT(&own) > 0) sched_setaffinity(0, sizeof own, &own);
}

/// Works on runs that it reads from standard input, line by line ("INDEX ID"), and answers each with a line on standard
/// output: a letter for the outcome (SweepWorkers), a space, and a text.
class RunWorker {
 public:
  explicit RunWorker(const WorkerOptions& options)
      : study_(read_study(options.sweep.file)),
        plan_(make_plan(study_, options.sweep.overrides)),
        checks_(options.check) {
    if (!checks_) folder_ = StudyFolder::open(study_, options.sweep.output);
    console_.quiet = true;
    resources_.bones = &bones_;
  }

  void work() {
    std::size_t run = 0;
    std::string id;
    while (!stop_requested() && std::cin >> run >> id) {
      const auto [letter, text] = outcome_of(run, id);
      std::printf("%c %s\n", letter, printable(text).c_str());
      std::fflush(stdout);
    }
  }

 private:
  std::pair<char, std::string> outcome_of(std::size_t run, const std::string& id) {
    try {
      return {'d', done(run, id)};
    } catch (const FolderInUse& error) {
      return {'b', message_of(error)};
    } catch (const Interrupted& error) {
      return {'i', message_of(error)};
    } catch (const InputError& error) {
      return {kWrongInput, message_of(error)};
    } catch (const std::exception& error) {
      return {'f', message_of(error)};
    }
  }

  std::string done(std::size_t run, const std::string& id) {
    if (run >= plan_.runs.size()) throw RunError("the study has changed while it was running; run it again");
    RunRequest request;
    request.scenario = scenario_of(study_, plan_.runs[run]);
    if (run_id(request.scenario, study_.keep, checksums_) != id) {
      throw RunError("the study or one of its files has changed while it was running; run it again");
    }
    if (!kernels_) kernels_ = prepare_opencl(request.scenario.engine.device, console_);
    if (checks_) return estimator_.estimate(request.scenario, resources_).text();
    request.dir = folder_->run_dir(id);
    request.overwrite = true;
    request.resume = true;
    request.keep = study_.keep;
    request.durable = false;
    RunConsole monitor(console_);
    Outputs pictures(console_);
    const auto continued_after = run_scenario(request, resources_, monitor, &pictures);
    return continued_after ? "continued after frame " + std::to_string(*continued_after) : "";
  }

  Study study_;
  StudyPlan plan_;
  bool checks_;
  std::optional<StudyFolder> folder_;  ///< not where it only checks
  Console console_;
  Checksums checksums_;
  BoneCache bones_;
  std::unique_ptr<cl::KernelCache> kernels_;  // before the devices
  RunResources resources_;
  RunEstimator estimator_;
};

void worker_command(const WorkerOptions& options) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);  // where the command that gives it runs is killed
  prctl(PR_SET_NAME, "reamsim");     // it was started by way of /proc/self/exe, and would be listed as "exe"
  take_processors(options.part);
  RunWorker(options).work();
}

}  // namespace

void add_sweep_worker(CLI::App& sweep) {
  auto* command = sweep.add_subcommand("worker", "")->group("");  // not listed: only SweepWorkers starts it
  auto options = std::make_shared<WorkerOptions>();
  options->sweep.add_to(*command);
  command->add_option("--part", options->part);
  command->add_flag("--check", options->check);
  command->callback([options] { worker_command(*options); });
}

}  // namespace reamsim
