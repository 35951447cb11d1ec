// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <CLI/CLI.hpp>
#include <memory>

#include "cli/commands.h"
#include "cli/environment.h"
#include "cli/outputs.h"
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
  Outputs pictures(console);
  run_scenario(request, resources, monitor, &pictures);
}

}  // namespace

void add_run_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("run", "Simulate a scenario and write forces, pictures, plots and grids");
  auto options = std::make_shared<RunOptions>();
  options->scenario.add_to(*command);
  add_output(*command, options->output, "Output folder (default: out/NAME)");
  command->add_flag("--overwrite", options->overwrite, "Replace an existing results folder once the run succeeds");
  command->add_flag("--resume", options->resume,
                    "Continue an interrupted run from its last checkpoint; without one, start at the first frame");
  auto* quiet = command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->add_flag("--verbose", console.verbose, "Print what each stage did")->excludes(quiet);
  command->callback([options, &console] { run_command(*options, console); });
}

}  // namespace reamsim
