// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/reforce.h"

#include <fmt/core.h>
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/environment.h"
#include "sim/base/error.h"
#include "sim/record/citation.h"
#include "sim/record/output_folder.h"

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

void print_figures(const RunTotals& totals, const Console& console) {
  console.say(
      fmt::format("peak axial force {:.1f} N, peak spin torque {:.0f} N mm, energy {:.4g} mJ; energy balance {:.1e}",
                  totals.peak_axial_force_n, totals.peak_spin_torque_nmm, totals.energy_mj, totals.balance));
}

/// Throws InputError for options that exclude one another.
void check_options(const ReforceOptions& options, bool recalibrates) {
  if (!std::filesystem::is_directory(options.dir)) {
    throw InputError({options.dir, 0, 0}, "", "folder not found", "expected the results folder of a finished run");
  }
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
    const ForcedStop forced = abandoning(folder);
    totals = write_reforced(run, law, folder.path());
    write_citation(folder.path(), cite_results(folder.path()));
    finish(folder, console);
    console.say("forces, summary and scenario: " + folder.final_path());
  }
  if (change) print_clamped(clamped_volume(run, change), console);
  print_figures(totals, console);
}

}  // namespace

void add_reforce_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("reforce", "Compute the forces of a finished run for other constants");
  auto options = std::make_shared<ReforceOptions>();
  command->add_option("DIR", options->dir, "Results folder of a run with output.force_basis: true")->required();
  add_overrides(*command, options->overrides, "Override a constant, for example cutting.specific_energy_j_mm3=0.2");
  add_output(*command, options->output, "Folder for forces.csv, summary.json and scenario.yaml");
  command->add_flag("--overwrite", options->overwrite,
                    "Replace the forces of DIR, or with -o an existing results folder");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->callback([options, &console] { reforce_command(*options, console); });
}

}  // namespace reamsim
