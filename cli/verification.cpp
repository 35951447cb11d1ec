// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// reamsim bench and verify: this build on this machine, against the paper's figures and against closed forms.

#include <fmt/core.h>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/environment.h"
#include "render/plots/plots.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/bench/paper.h"
#include "sim/bench/suite.h"
#include "sim/device/opencl.h"
#include "sim/record/citation.h"
#include "sim/record/output_folder.h"
#include "sim/scenario/parse.h"
#include "sim/verify/suite.h"

namespace reamsim {

namespace {

constexpr std::int64_t kMostFrames = 5000;

/// `reamsim bench --latency`: prints a line per scenario. Throws InputError, RunError, Interrupted.
void bench_latency(const std::vector<std::string>& scenarios, const std::string& device, const Console& console) {
  const auto kernels = prepare_opencl(device, console);
  std::vector<std::string> overrides;
  if (device != "auto") overrides.push_back("engine.device=" + device);
  for (const std::string& file : scenarios) {
    Diagnostics report;
    const auto warnings_of_error = print_on_error(report, console);
    const Scenario scenario = parse_scenario(file, overrides);
    SimulationInput scene = load_scene(scenario, report);
    const auto engine = load_engine(scene);
    const bench::Latency found = bench::frame_latency(scene, *engine, kMostFrames, stop_requested);
    if (found.frames == 0)
      throw InputError(
          {file, 0, 0}, "motion",
          fmt::format("no more than {} frames are in contact, which the measurement leaves out", bench::kWarmUpFrames),
          "a motion that reams for longer");
    console.say(
        fmt::format("{}, {:g} mm, {} on {}: {} frames in contact, median {:.3f} ms, 99 % {:.3f} ms, 99.9 % {:.3f} ms, "
                    "most {:.3f} ms",
                    scenario.name, scene.bone.voxmap->grid.voxel_mm, name_of(engine_of(scene.scenario)),
                    engine->device(), found.frames, found.median_ms, found.p99_ms, found.p999_ms, found.most_ms));
  }
}

struct BenchOptions {
  bool quick = false;
  bool exact = false;
  std::string json;
  std::string output = "out/bench";
  std::string device = "auto";
  bool overwrite = false;
  std::vector<std::string> engines;
  std::vector<std::string> latency;  ///< scenarios
};

/// Whether the file is a benchmark's JSON.
bool is_benchmark(const std::string& path) {
  return read_file_start(path, 256).starts_with("{\n  \"program\": \"reamsim ");
}

/// Throws InputError where the file cannot be written. Does not change it.
void require_writable(const std::string& path, bool overwrite) {
  require_replaceable_file(path, "--json", overwrite, is_benchmark, {});
  const bool existed = std::filesystem::exists(path);
  if (!std::ofstream(path, std::ios::binary | std::ios::app)) {
    throw InputError({path, 0, 0}, "--json", "cannot be written", "expected a file name in a folder that exists");
  }
  if (!existed) std::filesystem::remove(path);
}

/// Severe contact as curves over the shell, a panel per voxmap, and the times with and without VOI; engines without a
/// shell are level lines. The programs that the paper measured also get its figures.
BenchPlot plot_of(const bench::Json& report) {
  BenchPlot plot;
  plot.device = report["device"];
  for (const bench::Json& row : report["results"]) {
    const bench::Label who{row["engine"], row["variant"]};
    if (row["case"] != "severe" || who.engine == "exact") continue;
    const bool no_shell = who.engine == "implicit";
    const bool measured_there = no_shell || who.variant == "published";
    for (const bench::Json& shell : report["shells"]) {
      if (!no_shell && shell["shell"] != row["shell"]) continue;
      const auto paper = bench::paper_ms(who.engine, row["voxmap"], shell["shell"]);
      plot.severe.push_back(
          {name_of(who), row["voxmap"], shell["shell"], row["median_ms"], measured_there ? paper : std::nullopt});
    }
  }
  for (const bench::Json& row : report["voi"]) {
    plot.voi.push_back({name_of(bench::Label{row["engine"], row["variant"]}), 100 * row["fraction"].get<double>(),
                        row["with_ms"], row["without_ms"]});
  }
  return plot;
}

/// Measures, prints the tables and writes the JSON.
bench::Json measure(const bench::Plan& plan, const BenchOptions& options, const Console& console) {
  Progress progress(console, "bench", "steps");
  const auto part = [&](double fraction, const std::string& step) { progress.update_part(fraction, step); };
  bench::Json report = bench::run_bench(plan, {.part = part, .stop = stop_requested});
  progress.finish();
  console.say_lines("\n" + bench::text_of(report));
  const auto replace_bytes = bench::Json::error_handler_t::replace;
  if (!options.json.empty()) write_file(options.json, report.dump(2, ' ', false, replace_bytes) + "\n");
  return report;
}

/// Measures, and writes the figure of severe contact and of the VOI.
void measure_with_figure(const bench::Plan& plan, const BenchOptions& options, const Console& console) {
  OutputFolder folder(
      {.dir = options.output, .kind = ResultKind::benchmark, .overwrite = options.overwrite, .inputs = {}});
  const auto forced = abandoning(folder);
  const bench::Json report = measure(plan, options, console);
  const BenchPlot plot = plot_of(report);
  if (plot.severe.empty()) return console.warn("no engine could be measured: no figure written");
  write_bench_plot(folder.path(), plot);
  write_citation(folder.path(), cite_program());
  finish(folder, console);
  console.say("figure: " + folder.final_path() + "/bench.png");
}

void bench_command(const BenchOptions& options, const Console& console) {
  if (!options.latency.empty()) return bench_latency(options.latency, options.device, console);
  const auto kernels = prepare_opencl(options.device, console);
  bench::Plan plan = options.exact ? bench::sphere_plan() : options.quick ? bench::quick_plan() : bench::full_plan();
  plan.device = options.device;
  if (!options.engines.empty()) plan.engines = options.engines;
  bench::check_plan(plan);
  if (!options.json.empty()) require_writable(options.json, options.overwrite);
  if (options.exact) {
    measure(plan, options, console);
  } else {
    measure_with_figure(plan, options, console);
  }
  if (!options.json.empty()) console.say("measurements: " + options.json);
}

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
  if (options.device != "serial") cl::choose_device(options.device);
  OutputFolder folder(
      {.dir = options.output, .kind = ResultKind::verification, .overwrite = options.overwrite, .inputs = {}});
  const auto forced = abandoning(folder);
  Progress progress(console, "verify", "cases");
  const auto part = [&](double fraction, const std::string& name) { progress.update_part(fraction, name); };
  verify::Findings findings =
      verify::run_suite({.quick = options.quick, .device = options.device, .part = part, .stop = stop_requested});
  progress.finish();
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
    for (const verify::CaseFindings& found : findings.all_cases())
      console.say((found.passed() ? "pass  " : "FAIL  ") + found.title);
    console.say("report: " + report);
  }
  if (findings.passed()) return;
  for (const verify::CaseFindings& found : findings.all_cases()) {
    for (const verify::Check& check : found.checks)
      if (!check.passed()) console.warn(found.title + ": " + check.quantity + " exceeds its tolerance");
  }
  throw RunError(std::to_string(findings.failed_checks()) + " figures exceed their tolerance; see " + report);
}

}  // namespace

void add_bench_command(CLI::App& app, Console& console) {
  const auto [command, options] =
      add_command(app, "bench", "Benchmark every engine on this machine and compare with the paper's tables", console,
                  bench_command);
  auto* quick = command->add_flag("--quick", options->quick,
                                  "Short suite, a minute: severe and no contact, engines exact, bricked and direct");
  auto* exact =
      command
          ->add_flag("--exact", options->exact, "Only the plunged sphere with exact erosion, half a minute, no figure")
          ->excludes(quick);
  auto* latency =
      command
          ->add_option(
              "--latency", options->latency,
              "Only the wall time of single frames of these scenarios, pose in and force out: median, 99 and 99.9 %; "
              "writes no file")
          ->type_name("SCENARIO...")
          ->transform(shipped<ShippedKind::scenario>, "")
          ->excludes(quick)
          ->excludes(exact);
  add_path_option(*command, "--json", options->json, "Write the measurements as JSON", "FILE")->excludes(latency);
  add_output(*command, options->output, "Output folder for bench.png, bench.svg and bench.gp (default: out/bench)")
      ->excludes(exact)
      ->excludes(latency);
  command->add_flag("--overwrite", options->overwrite, "Replace an existing figure and JSON file")->excludes(latency);
  command->add_option("--device", options->device, "auto, or part of PLATFORM: NAME of an OpenCL device")
      ->type_name("NAME");
  command
      ->add_option("--engines", options->engines,
                   "Engines to measure: exact, bricked, direct, octree, implicit (default: all)")
      ->delimiter(',')
      ->type_name("E,E")
      ->excludes(exact)
      ->excludes(latency);
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors")->excludes(latency);
}

void add_verify_command(CLI::App& app, Console& console) {
  const auto [command, options] = add_command(
      app, "verify",
      "Verify this build and a device against analytical solutions and the serial reference; write a report", console,
      verify_command);
  command->add_flag("--quick", options->quick, "Short suite: coarser voxels, fewer runs");
  add_output(*command, options->output,
             "Output folder for device.md, verification.md, .json, .png and .svg (default: out/verify)");
  command->add_flag("--overwrite", options->overwrite, "Replace an existing report once the new one is complete");
  command->add_option("--device", options->device, "auto, serial, or part of PLATFORM: NAME of an OpenCL device")
      ->type_name("NAME");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->add_flag("--json", options->json, "Print the verification.json of the report");
}

}  // namespace reamsim
