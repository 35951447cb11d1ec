// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "cli/input_kind.h"
#include "cli/sweep.h"
#include "render/plots/uq_plot.h"
#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/statistics.h"
#include "sim/record/citation.h"
#include "sim/study/study_folder.h"
#include "sim/study/uq_outputs.h"

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

std::vector<double> column_of(const Eigen::MatrixXd& samples, Eigen::Index output) {
  const Eigen::VectorXd values = samples.col(output);
  return {values.begin(), values.end()};
}

/// uq.csv: quantiles of force and torque in every interval of time.
void write_bands(const std::string& dir, const UqResults& results) {
  CsvWriter out(dir + "/uq.csv",
                "time_s,axial_force_n_p05,axial_force_n_p50,axial_force_n_p95,spin_torque_nmm_p05,spin_torque_nmm_p50,"
                "spin_torque_nmm_p95");
  for (std::size_t i = 0; i < results.time_s.size(); ++i) {
    std::vector<double> axial, torque;
    for (const ForceHistory& history : results.histories) {
      axial.push_back(history.axial_force_n[i]);
      torque.push_back(history.spin_torque_nmm[i]);
    }
    out.row({results.time_s[i], quantile(axial, 0.05), quantile(axial, 0.5), quantile(axial, 0.95),
             quantile(torque, 0.05), quantile(torque, 0.5), quantile(torque, 0.95)});
  }
  out.close();
}

/// uq.json: by output its quantiles, and by input the indices.
void write_indices(const std::string& dir, const UqResults& results, std::size_t runs) {
  Json json;
  json["program"] = "reamsim " REAMSIM_VERSION;
  json["runs"] = runs;
  json["samples"] = results.samples.rows();
  for (std::size_t i = 0; i < results.outputs.size(); ++i) {
    const std::vector<double> values = column_of(results.samples, static_cast<Eigen::Index>(i));
    Json& output = json["outputs"][results.outputs[i]];
    output["p05"] = quantile(values, 0.05);
    output["p50"] = quantile(values, 0.5);
    output["p95"] = quantile(values, 0.95);
    output["dominant"] = results.dominant[i];
    for (std::size_t d = 0; d < results.inputs.size(); ++d) {
      const auto at = static_cast<Eigen::Index>(d);
      output["inputs"][results.inputs[d]] = {{"first_order", results.first[i][at]},
                                             {"first_order_error", results.first_error[i][at]},
                                             {"total", results.total[i][at]},
                                             {"total_error", results.total_error[i][at]},
                                             {"mean_in_lowest_fifth", results.low[i][at]},
                                             {"mean_in_highest_fifth", results.high[i][at]}};
    }
  }
  replace_file(dir + "/uq.json", json.dump(2) + "\n");
}

TornadoPlot tornado(const UqResults& results, std::size_t output) {
  TornadoPlot plot{.rows = {}, .mean = results.samples.col(static_cast<Eigen::Index>(output)).mean()};
  for (std::size_t d = 0; d < results.inputs.size(); ++d) {
    const auto at = static_cast<Eigen::Index>(d);
    plot.rows.push_back({results.inputs[d], results.low[output][at], results.high[output][at]});
  }
  return plot;
}

void print_results(const Console& console, const UqResults& results) {
  constexpr std::array kUnits{"N", "N mm", "mJ"};
  for (std::size_t i = 0; i < kUnits.size(); ++i) {
    const std::vector<double> values = column_of(results.samples, static_cast<Eigen::Index>(i));
    console.say(fmt::format("{}: {:.4g} {} (5 to 95 %: {:.4g} to {:.4g}); {}", results.outputs[i],
                            quantile(values, 0.5), kUnits[i], quantile(values, 0.05), quantile(values, 0.95),
                            results.dominant[i]));
  }
  console.say(
      "±: 95 % sampling error of an index as of independent samples (those of sobol scatter less), by which it may "
      "exceed 100 %; a larger sample.n lowers it");
}

void uq_command(const UqOptions& options, const Console& console) {
  const Study study = read_study(options.file);
  const UqDesign design(study);
  const std::string dir = options.output.empty() ? "out/" + study.name : options.output;
  keep_results_of_sweep(dir);
  design.require_valid_runs();
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
  std::vector<std::string> dirs;
  for (const IdentifiedRun& run : done.runs) dirs.push_back(folder.run_dir(run.id));
  const UqResults results = evaluate_uq(design, dirs);
  write_bands(marked, results);
  write_indices(marked, results, dirs.size());
  write_uq_plot(marked, tornado(results, 0), tornado(results, 1));
  write_citation(marked, cite_results(marked));
  print_results(console, results);
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
  command->add_option("-o,--output", options->output, "Folder of the study (default: out/NAME)")
      ->type_name("DIR")
      ->check(refuse_empty);
  add_jobs(*command, options->jobs);
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->callback([options, &console] { uq_command(*options, console); });
}

}  // namespace reamsim
