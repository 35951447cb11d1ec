// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <utility>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/environment.h"
#include "render/plots/plots.h"
#include "sim/base/error.h"
#include "sim/device/opencl.h"
#include "sim/record/citation.h"
#include "sim/record/output_folder.h"
#include "sim/verify/suite.h"

namespace reamsim {

namespace {

struct VerifyOptions {
  bool quick = false;
  std::string output = "out/verify";
  std::string device = "auto";
  bool overwrite = false;
  bool json = false;
};

/// Runs the suite and writes the report. Returns what was found, and where the report is.
std::pair<verify::Findings, std::string> verify_into_folder(const VerifyOptions& options, const Console& console) {
  const auto kernels = prepare_opencl(options.device, console);
  // Fail early where there is no such device or the report cannot be written.
  const std::string device = options.device == "serial" ? "serial" : cl::choose_device(options.device).name;
  OutputFolder folder(
      {.dir = options.output, .kind = ResultKind::verification, .overwrite = options.overwrite, .inputs = {}});
  const ForcedStop forced = abandoning(folder);
  verify::Setting setting;
  setting.quick = options.quick;
  setting.device = options.device;
  Progress progress(console, "verify", "cases");
  setting.part = [&](double fraction, const std::string& name) { progress.update_part(fraction, name); };
  setting.stop = stop_requested;
  verify::Findings findings = verify::run_suite(setting);
  progress.finish();
  findings.device = device;
  write_verification(folder.path(), findings);
  write_citation(folder.path(), cite_program());
  finish(folder, console);
  return {std::move(findings), folder.final_path() + "/verification.md"};
}

/// Prints verification.json or a line per case. Then throws RunError where a figure exceeds its tolerance.
void verify_command(const VerifyOptions& options, const Console& console) {
  std::pair<verify::Findings, std::string> done;
  const auto& [findings, report] = done;
  const auto run = [&](const Console& shown) { done = verify_into_folder(options, shown); };
  if (options.json) {
    run_with_json(console, run);
    std::fputs(verification_json(findings).c_str(), stdout);
  } else {
    run(console);
    for (const verify::CaseFindings& found : findings.cases) {
      console.say((found.passed() ? "pass  " : "FAIL  ") + found.title);
    }
    console.say("report: " + report);
  }
  if (findings.passed()) return;
  for (const verify::CaseFindings& found : findings.cases) {
    for (const verify::Check& check : found.checks) {
      if (!check.passed()) console.warn(found.title + ": " + check.quantity + " exceeds its tolerance");
    }
  }
  throw RunError(std::to_string(findings.failed_checks()) + " figures exceed their tolerance; see " + report);
}

}  // namespace

void add_verify_command(CLI::App& app, Console& console) {
  auto* command =
      app.add_subcommand("verify", "Verify this build against analytical solutions and write a citable report");
  auto options = std::make_shared<VerifyOptions>();
  command->add_flag("--quick", options->quick, "Short suite: coarser voxels, fewer runs");
  add_output(*command, options->output,
             "Output folder for verification.md, .json, .png and .svg (default: out/verify)");
  command->add_flag("--overwrite", options->overwrite, "Replace an existing report once the new one is complete");
  command->add_option("--device", options->device, "auto, serial, or part of the name of an OpenCL device")
      ->type_name("NAME");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->add_flag("--json", options->json, "Print the verification.json of the report");
  command->callback([options, &console] { verify_command(*options, console); });
}

}  // namespace reamsim
