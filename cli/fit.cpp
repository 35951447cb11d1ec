// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/commands.h"
#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/record/force_log.h"
#include "sim/record/output_folder.h"
#include "sim/record/result_json.h"
#include "sim/study/fit_forces.h"
#include "sim/study/reforce.h"

namespace reamsim {

namespace {

struct FitCommandOptions {
  std::string dir;
  std::string measured;
  std::string model = "law";
  std::vector<double> edges;
  bool fixed_normal_ratio = false;
  std::string output;
  std::string residuals;
  bool overwrite = false;
};

using Json = nlohmann::ordered_json;

std::vector<FrameTime> frames_of(const std::string& dir) {
  const std::vector<std::string_view> columns = csv_cells(kForceColumns);
  CsvReader log(dir + "/forces.csv", columns, "the log of a run");
  std::vector<FrameTime> out;
  for (std::vector<double> row; log.next(row);) {
    const FrameResult result = result_of(row, log.where());
    out.push_back({result.time_s, result.frame, result.pose.orientation * Vec3::UnitZ()});
  }
  return out;
}

std::string unit_of(const std::string& constant) {
  if (constant.starts_with("u")) return "J/mm3";
  return constant.starts_with("K") ? "N/mm" : "";
}

void print_constants(const ForceFit& fit, FitModel model, const Console& console) {
  std::vector<std::vector<std::string>> rows{{"constant", "value", "standard error", "unit", ""}};
  for (std::size_t i = 0; i < fit.constants.size(); ++i) {
    const FittedConstant& c = fit.constants[i];
    std::string note = c.fitted ? (c.at_bound ? "at its bound" : "") : "not fitted: that of the run";
    if (model == FitModel::classes && i < fit.classes.size())
      note += fmt::format("{:.3f} to {:.3f} g/cm3", fit.classes[i].least_g_cm3, fit.classes[i].most_g_cm3);
    rows.push_back({c.name, fmt::format("{:.6g}", c.value),
                    std::isnan(c.standard_error) ? "-" : fmt::format("{:.2g}", c.standard_error), unit_of(c.name),
                    note});
  }
  for (const std::string& line : align_columns(rows)) console.say(line);
}

void print_residuals(const ForceFit& fit, const Console& console) {
  std::vector<std::vector<std::string>> rows{{"column", "samples", "RMS measured", "RMS residual", "R2"}};
  for (const ChannelResidual& r : fit.residuals) {
    rows.push_back({column_of(r.channel), std::to_string(r.samples), fmt::format("{:.4g}", r.rms_measured),
                    fmt::format("{:.3g}", r.rms), fmt::format("{:.5f}", r.r_squared)});
  }
  for (const std::string& line : align_columns(rows)) console.say(line);
}

Json json_of(const ForceFit& fit, const FitCommandOptions& options) {
  Json json;
  json["program"] = "reamsim " REAMSIM_VERSION;
  json["model"] = options.model;
  std::vector<std::string> free;
  for (const FittedConstant& c : fit.constants) {
    json["constants"].push_back({{"name", c.name},
                                 {"value", c.value},
                                 {"standard_error", std::isnan(c.standard_error) ? Json() : Json(c.standard_error)},
                                 {"unit", unit_of(c.name)},
                                 {"fitted", c.fitted},
                                 {"at_bound", c.at_bound}});
    if (c.fitted && !c.at_bound) free.push_back(c.name);
  }
  json["covariance_of"] = free;
  for (Eigen::Index i = 0; i < fit.covariance.rows(); ++i) {
    const Eigen::VectorXd row = fit.covariance.row(i).transpose();
    json["covariance"].push_back(std::vector<double>(row.begin(), row.end()));
  }
  for (const DensityClass& c : fit.classes) {
    json["classes"].push_back({{"least_g_cm3", c.least_g_cm3},
                               {"most_g_cm3", c.most_g_cm3},
                               {"mean_g_cm3", c.mean_g_cm3},
                               {"removed_mm3", c.volume_mm3}});
  }
  for (const ChannelResidual& r : fit.residuals) {
    json["residuals"].push_back({{"column", column_of(r.channel)},
                                 {"samples", r.samples},
                                 {"rms_measured", r.rms_measured},
                                 {"rms", r.rms},
                                 {"r_squared", r.r_squared}});
  }
  json["statements"] = fit.statements;
  json["warnings"] = fit.warnings;
  return json;
}

/// Measured, fitted and residual of every column, at the measured times that are times of frames or lie between two.
void write_residuals(const std::string& path, const BasisRun& run, const std::vector<FrameTime>& frames,
                     const MeasuredForces& measured, const ForceFit& fit) {
  std::string header = "time_s";
  for (const ForceChannel channel : measured.channels)
    header += "," + column_of(channel) + ",fitted_" + column_of(channel) + ",residual_" + column_of(channel);
  CsvWriter out(path, header);
  const auto fitted = [&](ForceChannel channel, const FrameTime& frame) {
    const FrameForces forces = run.basis.forces(frame.frame, fit.force);
    return channel_value(channel, forces.force_n, forces.torque_nmm, frame.tool_z);
  };
  for (std::size_t i = 0; i < measured.time_s.size(); ++i) {
    const double time = measured.time_s[i];
    const auto after = std::ranges::lower_bound(frames, time - 1e-9, {}, &FrameTime::time_s);
    if (after == frames.end() || (after == frames.begin() && after->time_s > time + 1e-9)) continue;
    const FrameTime& before = after == frames.begin() ? *after : *(after - 1);
    const double step = after->time_s - before.time_s;
    const double t = step > 0 ? std::min(1.0, (time - before.time_s) / step) : 1;
    std::vector<double> row{time};
    for (std::size_t c = 0; c < measured.channels.size(); ++c) {
      const ForceChannel channel = measured.channels[c];
      const double value = (1 - t) * fitted(channel, before) + t * fitted(channel, *after);
      row.insert(row.end(), {measured.values[c][i], value, measured.values[c][i] - value});
    }
    out.row(row);
  }
  out.close();
}

bool is_fit(const std::string& path) {
  const Json json = parse_result_json(read_file_start(path, 1 << 20));
  return json.is_object() && json.contains("covariance_of");
}

bool is_residuals(const std::string& path) {
  return read_file_start(path, 4096).find(",residual_") != std::string::npos;
}

/// Throws InputError for options that contradict each other.
void check_options(const FitCommandOptions& options) {
  if (!options.edges.empty() && options.model != "classes") {
    throw InputError({}, "--class-edges", "has no effect with --model " + options.model, "add --model classes");
  }
  for (std::size_t i = 0; i < options.edges.size(); ++i) {
    if (options.edges[i] > (i == 0 ? 0 : options.edges[i - 1])) continue;
    throw InputError({}, "--class-edges", fmt::format("found {:g}", options.edges[i]),
                     "expected densities above 0, in ascending order");
  }
  const auto plain = [](const std::string& path) { return std::filesystem::absolute(path).lexically_normal(); };
  if (!options.output.empty() && !options.residuals.empty() && plain(options.output) == plain(options.residuals)) {
    throw InputError({}, "--residuals", "is the file of -o", "give each a file of its own");
  }
}

void fit_command(const FitCommandOptions& options, const Console& console) {
  check_options(options);
  const std::vector<std::string> inputs{options.dir, options.measured};
  if (!options.output.empty()) require_replaceable_file(options.output, "-o", options.overwrite, is_fit, inputs);
  if (!options.residuals.empty())
    require_replaceable_file(options.residuals, "--residuals", options.overwrite, is_residuals, inputs);
  const BasisRun run = open_basis_run(options.dir);
  const MeasuredForces measured = read_measured_forces(options.measured);
  const std::vector<FrameTime> frames = frames_of(options.dir);
  const FitModel model = options.model == "law" ? FitModel::law : FitModel::classes;
  const ForceFit fit =
      fit_forces(run.basis, frames, run.law.cutting, measured,
                 {.model = model, .class_edges_g_cm3 = options.edges, .fit_normal_ratio = !options.fixed_normal_ratio});
  if (!options.output.empty()) write_file(options.output, json_of(fit, options).dump(2) + "\n");
  if (!options.residuals.empty()) write_residuals(options.residuals, run, frames, measured, fit);
  print_constants(fit, model, console);
  print_residuals(fit, console);
  for (const std::string& statement : fit.statements) console.say(statement);
  for (const std::string& warning : fit.warnings) console.warn(warning);
  if (!options.output.empty()) console.say("constants: " + options.output);
  if (!options.residuals.empty()) console.say("measured and fitted values: " + options.residuals);
}

}  // namespace

void add_fit_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("fit", "Find the constants of the force law that best explain measured forces");
  auto options = std::make_shared<FitCommandOptions>();
  command->add_option("DIR", options->dir, "Results folder of a run with output.force_basis: true")->required();
  command
      ->add_option("MEASURED.csv", options->measured,
                   "time_s and any of axial_force_n, spin_torque_nmm, force_x_n, ..., torque_z_nmm")
      ->required();
  command
      ->add_option("--model", options->model,
                   "law: u0 and exponent of u0*(density/reference)^p; classes: one specific energy per density class")
      ->check(CLI::IsMember({"law", "classes"}));
  command
      ->add_option("--class-edges", options->edges,
                   "Densities between classes, g/cm3, ascending; without them classes end where the removed bone has a "
                   "gap of more than 0.05 g/cm3")
      ->delimiter(',');
  command->add_flag("--fixed-normal-ratio", options->fixed_normal_ratio, "Keep the normal ratio k_n of the run");
  command->add_option("-o,--output", options->output, "Write constants, covariance and residuals to this JSON file")
      ->type_name("FILE.json")
      ->check(refuse_empty);
  command->add_option("--residuals", options->residuals, "Write measured and fitted values to this CSV file")
      ->type_name("FILE.csv")
      ->check(refuse_empty);
  command->add_flag("--overwrite", options->overwrite, "Replace existing files of an earlier fit");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->callback([options, &console] { fit_command(*options, console); });
}

}  // namespace reamsim
