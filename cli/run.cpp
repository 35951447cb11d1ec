#include <fmt/core.h>
#include <CLI/CLI.hpp>
#include <memory>
#include <new>

#include "cli/commands.h"
#include "cli/outputs.h"
#include "render/pictures/figures.h"
#include "render/render.h"
#include "sim/base/error.h"
#include "sim/base/memory.h"
#include "sim/predict/contact_forecast.h"
#include "sim/record/output_folder.h"
#include "sim/record/summary.h"
#include "sim/run/measure.h"
#include "sim/run/simulation.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

struct RunOptions {
  ScenarioOptions scenario;
  std::string output;
  bool overwrite = false;
};

std::string output_dir(const RunOptions& options, const Scenario& scenario) {
  if (!options.output.empty()) return options.output;
  return scenario.output.dir.empty() ? "out/" + scenario.name : scenario.output.dir;
}

std::vector<std::string> files_read(const Scenario& scenario) {
  std::vector<std::string> files{scenario.file};
  for (const auto& [role, path] : input_files(scenario)) files.push_back(path);
  return files;
}

/// Records the warnings for summary.json and prints them.
void print_report(Report& report, RunFacts& facts, const Console& console) {
  facts.warnings.insert(facts.warnings.end(), report.warnings.begin(), report.warnings.end());
  console.print(report);
}

void run_frames(ReamingScene& scene, Engine& engine, Recorder& recorder, Outputs& outputs,
                const ContactForecast& contact, Report& report, const Console& console) {
  Progress progress(console, "simulate", "frames");
  RunControl control;
  control.progress = [&](std::int64_t done, std::int64_t total) {
    outputs.snapshots_written(done);
    progress.update(done, total);
  };
  control.stop = stop_requested;
  control.warned_of_no_contact = !contact.touches;
  simulate(scene, engine, recorder, control, report);
  progress.finish();
  recorder.close();
  outputs.snapshots_written(std::ssize(scene.motion.poses) - 1);  // also where that is frame 0
}

/// Prints the same figures, with the same names, as pictures, plots, summary and report have.
void print_summary(const Console& console, const RunTotals& totals, const RunFacts& facts, double mean_mm) {
  const Headline run = totals.headline(mean_mm > 0);
  console.say(fmt::format("removed {:.1f} mm3; {} {} mm; {} {} N, {} {} N mm; energy balance {:.1e}",
                          totals.removed_mm3, Headline::kDepthName, run.depth_text(), run.force_name(),
                          run.force_text(), run.torque_name(), run.torque_text(), totals.balance));
  console.say(fmt::format("{:.1f} s simulated in {:.1f} s on {}", totals.simulated_s, facts.simulate_s, facts.device));
}

/// Reports the segmentation and the predicted contact before the simulation.
ContactForecast report_scene(const ReamingScene& scene, const std::string& dir, Report& report,
                             const Console& console) {
  if (const auto& segmentation = scene.bone.segmentation) {
    console.say(sentence_of(*segmentation));
    if (scene.scenario.render.enabled) write_segmentation_picture(dir, *segmentation);
  }
  const ContactForecast contact = forecast_contact(scene);
  warn_of_contact(scene, contact, report);
  return contact;
}

/// Loads, simulates, writes and renders.
void run_in(OutputFolder& folder, const Scenario& scenario, const Console& console) {
  const Stopwatch load_watch;
  Report report;
  RunFacts facts;
  facts.inputs = input_sums(scenario);
  ReamingScene scene = load_scene(scenario, report);
  const ContactForecast contact = report_scene(scene, folder.path(), report, console);
  print_report(report, facts, console);
  std::unique_ptr<Engine> engine = load_engine(scene);
  facts.device = engine->device();
  facts.bone_before_mm3 = scene.bone.view().bone_mm3();
  return_free_memory();
  facts.load_s = load_watch.seconds();

  write_tool(folder.path(), scene.tool);
  Outputs outputs(scene, folder.path());
  Recorder recorder(folder.path(), scene.bone.voxmap->grid.voxel_mm);
  const Stopwatch watch;
  run_frames(scene, *engine, recorder, outputs, contact, report, console);
  facts.simulate_s = watch.seconds();
  facts.device_bytes = engine->device_bytes();
  print_report(report, facts, console);
  measure(facts, scene, outputs.fill_before(), recorder.totals());
  engine.reset();  // its copy of the fill is not needed any more, and writing needs memory
  return_free_memory();
  const Stopwatch write_watch;
  write_results(folder.path(), scene, recorder, facts);
  return_free_memory();
  facts.write_s = write_watch.seconds();
  const Stopwatch render_watch;
  const auto finish = [&] {
    print_report(report, facts, console);
    facts.render_s = render_watch.seconds();
    write_summary(folder.path(), scene, recorder.totals(), facts);
  };
  outputs.finish_run(scene.bone.fill);
  try {
    outputs.make(report, console);
  } catch (const RunError&) {
    finish();  // keep the numbers when pictures fail
    throw;
  } catch (const std::bad_alloc&) {
    finish();
    throw RunError(
        folder.path() +
        ": not enough memory for pictures and meshes; use smaller pictures, larger voxels, or output.meshes: false");
  }
  finish();
  outputs.make_report();
  print_summary(console, recorder.totals(), facts, outputs.mean_travel_mm());
}

void run_command(const RunOptions& options, const Console& console) {
  const Scenario scenario = options.scenario.parse();
  require_film_program(scenario.render);
  OutputFolder folder({.dir = output_dir(options, scenario),
                       .kind = ResultKind::run,
                       .overwrite = options.overwrite,
                       .inputs = files_read(scenario)});
  console.say("reamsim " REAMSIM_VERSION ": " + scenario.name + " -> " + folder.final_path());
  try {
    run_in(folder, scenario, console);
  } catch (const Interrupted&) {
    folder.keep();
    console.warn("interrupted; finished frames are in " + folder.path());
    throw;
  } catch (const std::exception& error) {
    if (!folder.has_frames()) throw;
    folder.keep();
    throw RunError(message_of(error) + "; finished frames are kept in " + folder.path());
  }
  folder.finish();
  console.say("results: " + folder.final_path());
}

}  // namespace

void add_run_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("run", "Simulate a scenario and write forces, pictures, plots and grids");
  auto options = std::make_shared<RunOptions>();
  options->scenario.add_to(*command);
  command->add_option("-o,--output", options->output, "Output folder (default: out/NAME)")->check(refuse_empty);
  command->add_flag("--overwrite", options->overwrite, "Replace an existing results folder once the run succeeds");
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
  command->add_flag("--verbose", console.verbose, "Print what each stage did");
  command->callback([options, &console] { run_command(*options, console); });
}

}  // namespace reamsim
