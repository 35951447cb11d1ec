// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/lab.h"
#include "cli/sweep.h"
#include "sim/record/citation.h"
#include "sim/scenario/show.h"
#include "sim/study/study_folder.h"
#include "sim/study/uq_design.h"

namespace reamsim {

namespace {

using Json = nlohmann::ordered_json;

/// Fewer points than this give sensitivity indices with errors of tenths.
constexpr int kTrusted = 64;

struct UqOptions {
  std::string file;
  std::string output;
  int jobs = 1;
};

/// The points of a design for the statistics: by point its run, its place in the unit cube, the constants there.
Json points_json(const UqDesign& design) {
  Json out = Json::array();
  for (const UqDesign::Point& point : design.points()) {
    std::vector<double> row{static_cast<double>(design.run_of(point))};
    row.insert(row.end(), point.begin(), point.end());
    for (const auto& [key, value] : design.constants(point)) row.push_back(value);
    out.push_back(std::move(row));
  }
  return out;
}

/// Of each run the force law at its first point, with the sampled constants, and that of the run. Throws InputError.
Json laws_json(const UqDesign& design, const std::vector<std::string>& run_dirs) {
  Json out = Json::array();
  if (!design.needs_basis()) return out;
  std::vector<std::vector<std::string>> constants(run_dirs.size());
  for (const UqDesign::Point& point : design.points()) {
    std::vector<std::string>& of_run = constants[design.run_of(point)];
    if (!of_run.empty()) continue;
    for (const auto& [key, value] : design.constants(point)) of_run.push_back(key + "=" + number_text(value));
  }
  for (std::size_t i = 0; i < run_dirs.size(); ++i) {
    const BasisRun run = open_basis_run(run_dirs[i]);
    out.push_back({{"law", law_json(changed_law(run, constants[i]))}, {"of_run", law_json(run.law)}});
  }
  return out;
}

/// Of each run the numbers of its summary that do not depend on the force law.
Json numbers_json(const std::vector<std::string>& run_dirs) {
  Json out = Json::array();
  for (const std::string& dir : run_dirs) {
    Json of_run = Json::object();
    for (const auto& [name, value] : read_run_summary(dir).numbers) {
      if (!depends_on_law(name)) of_run[name] = value;
    }
    out.push_back(std::move(of_run));
  }
  return out;
}

/// Bands and indices of the finished runs in `dir`.
void evaluate(const UqDesign& design, const SweepRuns& done, const StudyFolder& folder, const Console& console) {
  Json inputs = Json::array(), constants = Json::array(), ids = Json::array();
  for (const UncertainInput& input : design.inputs()) {
    inputs.push_back(input.name);
    if (input.constant) constants.push_back(input.name);
  }
  std::vector<std::string> run_dirs;
  for (const IdentifiedRun& run : done.runs) {
    ids.push_back(run.id);
    run_dirs.push_back(folder.run_dir(run.id));
    require_readable_log(run_dirs.back());
  }
  say_answer(call_lab("uq", {folder.path()},
                      {{"program", "reamsim " REAMSIM_VERSION},
                       {"inputs", inputs},
                       {"constants", constants},
                       {"n", design.samples()},
                       {"points", points_json(design)},
                       {"runs", ids},
                       {"laws", laws_json(design, run_dirs)},
                       {"numbers", numbers_json(run_dirs)}}),
             console);
}

void uq_command(const UqOptions& options, const Console& console) {
  const Study study = read_study(options.file);
  const UqDesign design(study);
  const std::string dir = options.output.empty() ? "out/" + study.name : options.output;
  keep_results_of_sweep(dir);
  design.require_valid_runs();
  require_lab();
  const std::string marked = StudyFolder(study, dir).path();
  const SweepOptions runs{.file = design.write_runs(marked), .output = marked, .overrides = {}};
  console.say(fmt::format("{}: {} uncertain inputs, {} evaluations of {} runs", study.name, design.inputs().size(),
                          design.points().size(), design.runs()));
  if (study.sample->n < kTrusted) {
    console.warn(fmt::format("sample.n is {}: with less than {}, sensitivity indices are a hint only", study.sample->n,
                             kTrusted));
  }
  const SweepRuns done = simulate_study(runs, options.jobs, console);
  const StudyFolder folder = StudyFolder::open(done.study, marked);
  evaluate(design, done, folder, console);
  write_citation(marked, cite_results(marked));
  console.say("bands and indices: " + marked + "/uq.csv, uq.json, uq.png");
}

}  // namespace

void add_uq_command(CLI::App& app, Console& console) {
  auto* command =
      app.add_subcommand("uq", "Propagate uncertain inputs: bands of force and torque, sensitivity indices");
  auto options = std::make_shared<UqOptions>();
  take_shipped_names(
      *command->add_option("STUDY", options->file, "Study file (YAML) with a sample, or the name of a shipped one")
           ->required(),
      ShippedKind::study);
  add_output(*command, options->output, "Folder of the study (default: out/NAME)");
  add_jobs(*command, options->jobs);
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->callback([options, &console] { uq_command(*options, console); });
}

}  // namespace reamsim
