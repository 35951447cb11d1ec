// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <CLI/CLI.hpp>
#include <memory>

#include "cli/commands.h"
#include "cli/environment.h"
#include "cli/run_console.h"
#include "render/pictures/figures.h"
#include "render/render.h"

namespace reamsim {

namespace {

struct RunOptions {
  ScenarioOptions scenario;
  std::string output;
  bool overwrite = false;
  bool resume = false;
};

void run_command(const RunOptions& options, const Console& console) {
  RunRequest request;
  request.scenario = options.scenario.parse();
  request.dir = options.output.empty() ? results_dir(request.scenario) : options.output;
  request.overwrite = options.overwrite;
  request.resume = options.resume;
  require_film_program(request.scenario.render);
  const auto kernels = prepare_opencl(request.scenario.engine.device, console);
  RunResources resources;
  RunConsole monitor(console);
  RunPictures pictures(console);
  run_scenario(request, resources, monitor, &pictures);
}

}  // namespace

void add_run_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("run", "Simulate a scenario and write forces, pictures, plots and grids");
  auto options = std::make_shared<RunOptions>();
  options->scenario.add_to(*command);
  command->add_option("-o,--output", options->output, "Output folder (default: out/NAME)")
      ->type_name("DIR")
      ->check(refuse_empty);
  command->add_flag("--overwrite", options->overwrite, "Replace an existing results folder once the run succeeds");
  command->add_flag("--resume", options->resume,
                    "Continue an interrupted run from its last checkpoint; without one, start at the first frame");
  auto* quiet = command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->add_flag("--verbose", console.verbose, "Print what each stage did")->excludes(quiet);
  command->callback([options, &console] { run_command(*options, console); });
}

void RunConsole::say(const std::string& line) {
  progress_.reset();
  console_.say(line);
}

void RunConsole::take(const Diagnostics& report) {
  progress_.reset();
  Diagnostics printed = report;
  console_.print(printed);
}

void RunConsole::progress(std::int64_t done, std::int64_t total) {
  if (!progress_) progress_.emplace(console_, "simulate", "frames");
  if (done > 0) progress_->update(done, total);
}

std::shared_ptr<void> RunConsole::on_forced_end(std::function<InterruptedRun()> end) {
  return std::make_shared<ForcedStop>([end = std::move(end)]() -> StopOutcome {
    const InterruptedRun remains = end();
    return {remains.saved ? kSuspendedStatus : kInterruptedStatus, remains.message};
  });
}

void RunPictures::draw_segmentation(const SimulationInput& scene, const std::string& dir) {
  if (scene.scenario.render.enabled) write_segmentation_picture(dir, *scene.bone.segmentation);
}

void RunPictures::end(const SimulationInput& scene, const std::string& dir) {
  if (outputs_) {
    outputs_->finish_run(scene.bone.fill);
  } else {
    outputs_.emplace(Outputs::of_finished(scene, dir));
  }
}

}  // namespace reamsim
