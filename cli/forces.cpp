// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// reamsim reforce and fit: other constants of the force law for a finished run, and those of measured forces.

#include <fmt/core.h>
#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/lab.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/record/citation.h"
#include "sim/record/output_folder.h"
#include "sim/record/result_json.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/parse.h"
#include "sim/study/reforce.h"

namespace reamsim {

namespace {

struct ReforceOptions {
  std::string dir;
  std::string output;
  std::vector<std::string> overrides;
  bool overwrite = false;
};

void print_clamped(const ClampedVolume& clamped, const Console& console) {
  if (!(clamped.whole_mm3 > 0)) return;
  if (clamped.at_most_mm3 > 0) {
    console.warn(
        fmt::format("{:.3g} of {:.4g} mm3 of removed bone had 2 g/cm3 or more in the run, and are taken as 2: "
                    "their density after another calibration is not known",
                    clamped.at_most_mm3, clamped.whole_mm3));
  }
  if (clamped.beyond_mm3 > 0) {
    console.warn(
        fmt::format("{:.3g} of {:.4g} mm3 of removed bone would exceed 2 g/cm3, and are taken as 2, as in a run",
                    clamped.beyond_mm3, clamped.whole_mm3));
  }
}

/// Throws InputError for options that exclude one another.
void check_options(const ReforceOptions& options, bool recalibrates) {
  if (!std::filesystem::is_directory(options.dir))
    refuse_file(options.dir, "folder not found", "expected the results folder of a finished run");
  if (options.output.empty() && !options.overwrite)
    throw InputError({}, "-o", "no output given", "give -o DIR, or --overwrite to replace the forces of the run");
  if (options.output.empty() && recalibrates) {
    throw InputError({}, "--set", "bone.density: the density grades of the run would not match its scenario any more",
                     "give -o DIR for another calibration");
  }
}

void reforce_command(const ReforceOptions& options, const Console& console) {
  if (!options.output.empty() || options.overwrite) check_options(options, false);
  const BasisRun run = open_basis_run(options.dir);
  const LawSettings law = changed_law(run, options.overrides);
  const auto change = recalibration(run, law);
  check_options(options, change.has_value());
  RunTotals totals(run.voxel_mm);
  if (options.output.empty()) {
    ResultUpdate update(options.dir, ResultKind::run);
    totals = write_reforced(run, law, options.dir);
    update.finish();
    console.say("forces, summary and scenario replaced in " + options.dir +
                "; `reamsim render` draws its plots and report again");
  } else {
    OutputFolder folder(
        {.dir = options.output, .kind = ResultKind::run, .overwrite = options.overwrite, .inputs = {options.dir}});
    folder.clear();
    const auto forced = abandoning(folder);
    totals = write_reforced(run, law, folder.path());
    write_citation(folder.path(), cite_results(folder.path()));
    finish(folder, console);
    console.say("forces, summary and scenario: " + folder.final_path());
  }
  if (change) print_clamped(clamped_volume(run, change), console);
  console.say(
      fmt::format("peak axial force {:.1f} N, peak spin torque {:.0f} N mm, energy {:.4g} mJ; energy balance {:.1e}",
                  totals.peak_axial_force_n, totals.peak_spin_torque_nmm, totals.energy_mj, totals.balance));
}

struct FitOptions {
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

/// Of the constants of a fit, by name ("u": of a class), the scenario's key and what it accepts; and the least energy
/// of bone that the project assumes.
Json limits() {
  static constexpr std::array<std::pair<const char*, const char*>, 6> kKeys{
      {{"u0", "cutting.specific_energy_j_mm3"},
       {"u", "cutting.specific_energy_table.0.energy_j_mm3"},
       {"p", "cutting.density_exponent"},
       {"k_n", "cutting.normal_ratio"},
       {"K_t", "cutting.edge_force.tangential_n_mm"},
       {"K_n", "cutting.edge_force.normal_n_mm"}}};
  Json keys;
  for (const auto& [name, key] : kKeys) {
    const Range& range = find_key(key, {}).info.range;
    keys[name] = {{"key", key}, {"min", range.min}, {"max", range.max}, {"text", range_text(range)}};
  }
  CuttingSettings low{.preset = EnergyPreset::assumed_low};
  apply_preset({}, low);
  return {{"keys", keys},
          {"least_energy",
           {{"specific_energy_j_mm3", low.specific_energy_j_mm3},
            {"reference_density_g_cm3", low.reference_density_g_cm3},
            {"density_exponent", low.density_exponent}}}};
}

/// NaN becomes null.
Json json_of(const MeasuredForces& measured) {
  Json out = Json::object();
  for (std::size_t i = 0; i < measured.columns.size(); ++i) out[measured.columns[i]] = measured.values[i];
  return out;
}

bool is_fit(const std::string& path) {
  const Json json = parse_result_json(read_file_start(path, 1 << 20));
  return json.is_object() && json.contains("covariance_of");
}

bool is_residuals(const std::string& path) {
  return read_file_start(path, 4096).find(",residual_") != std::string::npos;
}

/// Throws InputError for options that contradict each other.
void check_options(const FitOptions& options) {
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

void fit_command(const FitOptions& options, const Console& console) {
  check_options(options);
  const std::vector<std::string> inputs{options.dir, options.measured};
  if (!options.output.empty()) require_replaceable_file(options.output, "-o", options.overwrite, is_fit, inputs);
  if (!options.residuals.empty())
    require_replaceable_file(options.residuals, "--residuals", options.overwrite, is_residuals, inputs);
  const BasisRun run = open_basis_run(options.dir);
  const MeasuredForces measured = read_measured_forces(options.measured);
  require_readable_log(options.dir);
  say_answer(call_lab("fit", {options.dir, options.measured, options.output, options.residuals},
                      {{"program", "reamsim " REAMSIM_VERSION},
                       {"law", law_json(run.law)},
                       {"time_s", measured.time_s},
                       {"measured", json_of(measured)},
                       {"model", options.model},
                       {"class_edges_g_cm3", options.edges},
                       {"fit_normal_ratio", !options.fixed_normal_ratio},
                       {"limits", limits()}}),
             console);
  if (!options.output.empty()) console.say("constants: " + options.output);
  if (!options.residuals.empty()) console.say("measured and fitted values: " + options.residuals);
}

}  // namespace

void add_reforce_command(CLI::App& app, Console& console) {
  const auto [command, options] =
      add_command(app, "reforce", "Compute the forces of a finished run for other constants", console, reforce_command);
  command->add_option("DIR", options->dir, "Results folder of a run with output.force_basis: true")->required();
  add_overrides(*command, options->overrides, "Override a constant, for example cutting.specific_energy_j_mm3=0.2");
  add_output(*command, options->output, "Folder for forces.csv, summary.json and scenario.yaml");
  command->add_flag("--overwrite", options->overwrite,
                    "Replace the forces of DIR, or with -o an existing results folder");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
}

void add_fit_command(CLI::App& app, Console& console) {
  const auto [command, options] = add_command(
      app, "fit", "Find the constants of the force law that best explain measured forces", console, fit_command);
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
  add_output(*command, options->output, "Write constants, covariance and residuals to this JSON file", "FILE.json");
  add_path_option(*command, "--residuals", options->residuals, "Write measured and fitted values to this CSV file",
                  "FILE.csv");
  command->add_flag("--overwrite", options->overwrite, "Replace existing files of an earlier fit");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
}

}  // namespace reamsim
