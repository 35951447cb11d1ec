#include <CLI/CLI.hpp>
#include <memory>

#include "cli/commands.h"
#include "cli/environment.h"
#include "render/report/verify_report.h"
#include "sim/base/error.h"
#include "sim/device/opencl.h"
#include "sim/record/output_folder.h"
#include "sim/verify/suite.h"

namespace reamsim {

namespace {

struct VerifyOptions {
  bool quick = false;
  std::string output = "out/verify";
  std::string device = "auto";
  bool overwrite = false;
};

/// The figures that failed, one per line.
void print_failures(const verify::Findings& findings, const Console& console) {
  for (const verify::CaseFindings& found : findings.cases) {
    for (const verify::Check& check : found.checks) {
      if (!check.passed()) console.warn(found.title + ": " + check.quantity + " exceeds its tolerance");
    }
  }
}

void verify_command(const VerifyOptions& options, const Console& console) {
  const auto kernels = prepare_opencl(options.device, console);
  // Fail early where there is no such device or the report cannot be written.
  const std::string device = options.device == "serial" ? "serial" : cl::choose_device(options.device).name;
  OutputFolder folder(
      {.dir = options.output, .kind = ResultKind::verification, .overwrite = options.overwrite, .inputs = {}});
  const ForcedStop forced = abandoning(folder);
  verify::Setting setting;
  setting.quick = options.quick;
  setting.device = options.device;
  setting.progress = [&](const std::string& stage) { console.say("... " + stage); };
  setting.stop = stop_requested;
  verify::Findings findings = verify::run_suite(setting);
  findings.device = device;
  write_verification(folder.path(), findings);
  finish(folder, console);
  for (const verify::CaseFindings& found : findings.cases) {
    console.say((found.passed() ? "pass  " : "FAIL  ") + found.title);
  }
  const std::string report = folder.final_path() + "/verification.md";
  console.say("report: " + report);
  if (findings.passed()) return;
  print_failures(findings, console);
  throw RunError(std::to_string(findings.failed_checks()) + " figures exceed their tolerance; see " + report);
}

}  // namespace

void add_verify_command(CLI::App& app, Console& console) {
  auto* command =
      app.add_subcommand("verify", "Verify this build against analytical solutions and write a citable report");
  auto options = std::make_shared<VerifyOptions>();
  command->add_flag("--quick", options->quick, "Short suite: coarser voxels, fewer runs");
  command
      ->add_option("-o,--output", options->output,
                   "Output folder for verification.md, .json, .png and .svg (default: out/verify)")
      ->check(refuse_empty);
  command->add_flag("--overwrite", options->overwrite, "Replace an existing report once the new one is complete");
  command->add_option("--device", options->device, "auto, serial, or part of the name of an OpenCL device")
      ->type_name("NAME");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->callback([options, &console] { verify_command(*options, console); });
}

}  // namespace reamsim
