// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <sched.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "cli/console.h"
#include "cli/environment.h"
#include "cli/outputs.h"
#include "cli/sweep.h"
#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/base/text.h"
#include "sim/record/output_folder.h"
#include "sim/run/cost_estimate.h"
#include "sim/run/simulation.h"
#include "sim/scenario/passes.h"
#include "sim/scene/clearance.h"
#include "sim/scene/contact_forecast.h"
#include "sim/study/study_folder.h"

namespace reamsim {

namespace {

/// The arguments of a worker, which work_on() gives it. Without the study's folder it only checks.
struct WorkerOptions {
  SweepOptions sweep;
  std::string part;  ///< "i/n": its part of the processors
};

constexpr double kEstimateTiming_s = 0.1;

/// Validates runs as `reamsim check` does, and estimates their cost. Of runs with the same bone, tool and force basis,
/// only the first is timed.
class RunEstimator {
 public:
  /// `resources` must have a cache of bones. Throws InputError with every mistake of the scenario.
  RunEstimate estimate(const Scenario& scenario, RunResources& resources) {
    const Stopwatch watch;
    Diagnostics report;
    MistakeList mistakes;
    SimulationInput scene = load_scene(scenario, report, mistakes, resources.bones);
    mistakes.throw_if_any();
    RunEstimate out{.load_s = watch.seconds(), .frames = scene.last_frame(), .warnings = {}};
    const std::vector<ContactForecast> contacts = forecast_passes(scene);
    warn_of_contact(scene, contacts, report);
    if (const auto clearance = find_clearance(scene)) warn_of_clearance(*clearance, scene, report);
    out.warnings = report.warnings;
    do {
      out.memory_bytes = std::max(out.memory_bytes, plan_memory(scene).process_bytes);
      out.simulate_s += simulate_s(scene, resources);
    } while (begin_next_pass(scene));
    return out;
  }

 private:
  double simulate_s(SimulationInput& scene, RunResources& resources) {
    const auto frames = static_cast<double>(scene.motion.last_frame() - scene.motion.first_frame + 1);
    const std::vector<PassSpec> passes = passes_of(scene.scenario);
    const std::tuple key{resources.bones->loaded(), passes[static_cast<std::size_t>(scene.motion.pass) - 1].tool.mesh,
                         scene.scenario.output.force_basis};
    const auto known = s_per_frame_.find(key);
    if (known != s_per_frame_.end()) return known->second * frames;
    const auto engine = load_engine(scene, resources.devices);  // also finds what does not fit the device
    const double seconds = plan_time(scene, *engine, kEstimateTiming_s).simulate_s;
    s_per_frame_[key] = seconds / std::max(1.0, frames);
    return seconds;
  }

  /// By bone (BoneCache::loaded), tool, and whether a force basis is written, which takes longer than the frames.
  std::map<std::tuple<int, std::string, bool>, double> s_per_frame_;
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
/// output (WorkerAnswer).
class RunWorker {
 public:
  explicit RunWorker(const WorkerOptions& options)
      : study_(read_study(options.sweep.file)), plan_(make_plan(study_, options.sweep.overrides)) {
    if (!options.sweep.output.empty()) folder_ = StudyFolder::open(study_, options.sweep.output);
    console_.quiet = true;
    resources_.bones = &bones_;
  }

  void work() {
    std::size_t run = 0;
    std::string id;
    while (!stop_requested() && std::cin >> run >> id) {
      const auto [outcome, text] = outcome_of(run, id);
      std::printf("%c %s\n", static_cast<char>(outcome), printable(text).c_str());
      std::fflush(stdout);
    }
  }

 private:
  using Outcome = WorkerAnswer::Outcome;

  std::pair<Outcome, std::string> outcome_of(std::size_t run, const std::string& id) {
    try {
      return {Outcome::done, done(run, id)};
    } catch (const FolderInUse& error) {
      return {Outcome::busy, message_of(error)};
    } catch (const Interrupted& error) {
      return {Outcome::interrupted, message_of(error)};
    } catch (const InputError& error) {
      return {Outcome::wrong_input, message_of(error)};
    } catch (const std::exception& error) {
      return {Outcome::failed, message_of(error)};
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
    if (!folder_) {
      const nlohmann::json estimate = estimator_.estimate(request.scenario, resources_);
      return estimate.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    }
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
  auto* command = sweep.add_subcommand("worker", "")->group("");  // not listed: only work_on() starts it
  auto options = std::make_shared<WorkerOptions>();
  options->sweep.add_to(*command);
  command->add_option("--part", options->part);
  command->callback([options] { worker_command(*options); });
}

}  // namespace reamsim
