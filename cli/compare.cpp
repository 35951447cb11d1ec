// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/plots.h"

#include <fmt/core.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "cli/commands.h"
#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/record/citation.h"
#include "sim/record/output_folder.h"
#include "sim/record/run_totals.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/paths.h"
#include "sim/study/reforce.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

struct CompareOptions {
  std::vector<std::string> dirs;
  std::string output = "out/compare";
  std::string color_by;
  bool overwrite = false;
};

/// With more runs the table has no relative differences, and no metric that is the same in all of them.
constexpr std::size_t kMostWithDifferences = 8;

/// The metrics on the terminal; runs.csv has all.
constexpr std::array kShown{
    "removed_mm3",         "headline.depth_mm",  "headline.peak_axial_force_n", "headline.peak_spin_torque_nmm",
    "energy_mj",           "forces.rms_force_n", "forces.rms_torque_nmm",       "bone.voxel_mm",
    "bone.bone_after_mm3", "simulated_s"};

/// Throws InputError unless there are two or more different folders of finished runs.
void check_folders(const std::vector<std::string>& dirs) {
  if (dirs.size() < 2) throw InputError({}, "DIR", "only one folder given", "give two or more results folders");
  std::set<fs::path> seen;
  for (const std::string& dir : dirs) {
    std::error_code error;
    if (!fs::is_directory(dir, error))
      refuse_file(dir, "folder not found", "expected the results folder of a finished run");
    if (!seen.insert(fs::canonical(dir)).second) refuse_file(dir, "folder given twice", "give different runs");
    for (const char* file : {"summary.json", "forces.csv", "scenario.yaml"}) {
      if (fs::is_regular_file(dir + "/" + file, error)) continue;
      refuse_file(dir, std::string("has no ") + file, "expected the results folder of a finished run");
    }
  }
}

/// The names of the folders, or their paths where two have the same name.
std::vector<ComparedRun> label_runs(const std::vector<std::string>& dirs) {
  std::vector<ComparedRun> runs;
  std::set<std::string> names;
  for (const std::string& dir : dirs) {
    runs.push_back({dir, fs::canonical(dir).filename().string()});
    names.insert(runs.back().label);
  }
  if (names.size() == runs.size()) return runs;
  for (ComparedRun& run : runs) run.label = recorded_text(run.dir);
  return runs;
}

/// "1.5 (+12.3 %)", or of many runs "1.5".
std::string entry(const ComparedMetric& metric, std::size_t run) {
  const double relative = metric.relative(run);
  const bool differs = run > 0 && metric.values.size() <= kMostWithDifferences && std::isfinite(relative);
  return (std::isfinite(metric.values[run]) ? rounded_text(metric.values[run]) : "-") +
         (differs ? fmt::format(" ({:+.2f} %)", 100 * relative) : "");
}

bool is_left_out(const ComparedMetric& metric) {
  const auto is_first = [&](double value) { return value == metric.values[0]; };
  return metric.values.size() > kMostWithDifferences && std::ranges::all_of(metric.values, is_first);
}

void print_table(const Console& console, const Comparison& comparison) {
  std::vector<RunColumn> columns;
  for (const ComparedParameter& parameter : comparison.parameters) {
    columns.push_back({printable(parameter.key), {}});
    for (const std::string& value : parameter.shown)
      columns.back().cells.push_back(value.empty() ? "-" : printable(value));
  }
  for (const char* key : kShown) {
    const auto found = std::ranges::find(comparison.metrics, key, &ComparedMetric::key);
    const bool is_column = std::ranges::find(columns, key, &RunColumn::key) != columns.end();
    if (found == comparison.metrics.end() || is_column || is_left_out(*found)) continue;
    columns.push_back({key, {}});
    for (std::size_t i = 0; i < comparison.runs.size(); ++i) columns.back().cells.push_back(entry(*found, i));
  }
  std::vector<std::string> labels;
  for (const ComparedRun& run : comparison.runs) labels.push_back(printable(run.label));
  for (const std::string& line : run_table(labels, columns, kTerminalWidth)) console.say(line);
}

void compare_command(const CompareOptions& options, const Console& console) {
  check_folders(options.dirs);
  Comparison comparison{label_runs(options.dirs), {}, {}, options.color_by};
  comparison.metrics = compare_summaries(comparison.runs);
  comparison.parameters = compare_scenarios(comparison.runs);
  for (ComparedRun& run : comparison.runs) {  // means as in the run's own plots
    const double voxel_mm = voxel_mm_of(run.dir);
    run.mean_travel_mm = averaged_travel_mm(parse_result_settings(run.dir + "/scenario.yaml").cutting, voxel_mm);
  }
  colored_by(comparison);  // refuses a wrong key before a folder is made
  OutputFolder folder(
      {.dir = options.output, .kind = ResultKind::comparison, .overwrite = options.overwrite, .inputs = options.dirs});
  const auto forced = abandoning(folder);
  write_comparison(folder.path(), comparison);
  write_citation(folder.path(), cite_runs(options.dirs));
  finish(folder, console);
  print_table(console, comparison);
  if (comparison.runs.size() <= kMostWithDifferences)
    console.say("differences are relative to " + comparison.runs[0].label);
  console.say("figure: " + folder.final_path() + "/compare.png");
  console.say("all numbers: " + folder.final_path() + "/runs.csv, and differences: compare.csv");
}

}  // namespace

void add_compare_command(CLI::App& app, Console& console) {
  const auto [command, options] =
      add_command(app, "compare", "Compare finished runs: curves in one figure, differences in one table", console,
                  compare_command);
  command->add_option("DIR", options->dirs, "Results folders of finished runs; differences are relative to the first")
      ->required();
  add_output(*command, options->output, "Output folder (default: out/compare)");
  command
      ->add_option("--color-by", options->color_by,
                   "Colour the curves by a number: a differing key of the scenario, or a key of summary.json")
      ->check(refuse_empty);
  command->add_flag("--overwrite", options->overwrite, "Replace an existing comparison once this one succeeds");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
}

}  // namespace reamsim
