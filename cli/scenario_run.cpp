// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/scenario_run.h"

#include <fmt/core.h>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>

#include "cli/commands.h"
#include "cli/outputs.h"
#include "cli/run_checkpoints.h"
#include "render/pictures/figures.h"
#include "render/plots/plots.h"
#include "sim/base/error.h"
#include "sim/base/memory.h"
#include "sim/predict/contact_forecast.h"
#include "sim/record/citation.h"
#include "sim/record/clearance_file.h"
#include "sim/record/output_folder.h"
#include "sim/record/summary.h"
#include "sim/run/measure.h"
#include "sim/run/peak_warnings.h"
#include "sim/run/simulation.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

std::vector<std::string> files_read(const Scenario& scenario) {
  std::vector<std::string> files{scenario.file};
  for (const auto& [role, path] : input_files(scenario)) files.push_back(path);
  return files;
}

/// Prints the same figures, with the same names, as pictures, plots, summary and report have.
void print_summary(const Console& console, const RunTotals& totals, const RunFacts& facts, double mean_mm) {
  const Headline run = totals.headline(mean_mm > 0);
  console.say(fmt::format("removed {:.1f} mm3; {} {} mm; {} {} N, {} {} N mm; energy balance {:.1e}",
                          totals.removed_mm3, Headline::kDepthName, run.depth_text(), run.force_name(),
                          run.force_text(), run.torque_name(), run.torque_text(), totals.balance));
  for (std::size_t i = 0; i < totals.passes.size() && totals.passes.size() > 1; ++i) {
    const PassTotals& pass = totals.passes[i];
    console.say(
        fmt::format("pass {}: removed {:.1f} mm3; tool depth {:.2f} mm; peak axial force {:.1f} N, peak spin "
                    "torque {:.0f} N mm",
                    i + 1, pass.removed_mm3, pass.max_depth_mm, pass.peak_axial_force_n, pass.peak_spin_torque_nmm));
  }
  console.say(fmt::format("{:.1f} s simulated in {:.1f} s on {}", totals.simulated_s, facts.simulate_s, facts.device));
}

/// A run of a scenario into a folder: load, simulate, write, render.
class ScenarioRun {
 public:
  ScenarioRun(const std::string& dir, const RunRequest& request, RunResources& resources, RunCheckpoints& checkpoints,
              const Console& console)
      : dir_(dir),
        scenario_(request.scenario),
        keep_(request.keep),
        resources_(resources),
        checkpoints_(checkpoints),
        console_(console) {}

  void run() {
    const PrintOnError warnings_of_error(report_, console_);
    load();
    Recorder recorder = checkpoints_.open_logs(scene_.bone.voxmap->grid.voxel_mm, scenario_, report_);
    simulate_frames(recorder);
    write(recorder);
    if (outputs_) {
      render(recorder.totals());
    } else {
      finish_summary(recorder.totals());
    }
    remove_logs();
    print_summary(console_, recorder.totals(), facts_, mean_travel_mm());
  }

  /// Whether frames have been simulated, or are.
  [[nodiscard]] bool simulates() const { return simulates_; }

 private:
  void load() {
    const Stopwatch watch;
    facts_.inputs = input_sums(scenario_);
    checkpoints_.identify(scenario_, facts_.inputs);
    scene_ = load_scene(scenario_, report_, resources_.bones);
    report_segmentation();
    contacts_ = forecast_passes(scene_);
    scene_.contact = contact_frames(contacts_);
    warn_of_contact(scene_, contacts_, report_);
    find_clearance_of_holder();
    print_report();
    facts_.bone_before_mm3 = scene_.bone.view().bone_mm3();
    if (keep_.pictures) {
      write_tools(dir_, scene_);
    }
    if (keep_.pictures && scenario_.motion.is_prescribed()) {
      outputs_.emplace(scene_, dir_);
    } else {
      fill_before_ = scene_.bone.fill;
    }
    checkpoints_.restore(scene_.bone.fill);
    skip_finished_passes();
    engine_ = load_engine(scene_, resources_.devices);
    facts_.device = engine_->device();
    checkpoints_.use_device(facts_.device, report_);
    write_scenario(dir_, scene_, facts_);
    return_free_memory();
    facts_.load_s = watch.seconds();
  }

  /// A run that continues begins with the pass of its checkpoint.
  void skip_finished_passes() {
    const auto state = checkpoints_.state();
    while (state && !scene_.motion.push && state->frame >= scene_.motion.last_frame() && begin_next_pass(scene_)) {
    }
  }

  void find_clearance_of_holder() {
    facts_.clearance = find_clearance(scene_);
    if (!facts_.clearance) return;
    console_.say(sentence_of(*facts_.clearance, scene_));
    warn_of_clearance(*facts_.clearance, scene_, report_);
    write_clearance(dir_ + "/clearance.csv", *facts_.clearance, scene_.motion.frame_s());
  }

  void report_segmentation() const {
    const auto& segmentation = scene_.bone.segmentation;
    if (!segmentation) return;
    console_.say(sentence_of(*segmentation));
    if (keep_.pictures && scenario_.render.enabled) write_segmentation_picture(dir_, *segmentation);
  }

  void simulate_frames(Recorder& recorder) {
    simulates_ = true;
    const StopGrace until_saved;
    Progress progress(console_, "simulate", "frames");
    const auto save = [&](const SimulationState& state) {
      const bool saved = checkpoints_.save(state, recorder, scene_.bone.fill, report_);
      if (saved) write_summary(dir_, scene_, recorder.totals(), facts_, /*finished=*/false);
    };
    RunControl control{.save_due = [this] { return checkpoints_.due(); }, .save = save, .from = checkpoints_.state()};
    control.progress = [&](std::int64_t done, std::int64_t total) {
      if (outputs_) outputs_->snapshots_written(done);
      progress.update(done, total);
    };
    control.stop = stop_requested;
    const Stopwatch watch;
    SimulationState end;
    do {
      control.warned_of_no_contact = !contacts_[static_cast<std::size_t>(scene_.motion.pass) - 1].touches;
      end = simulate(scene_, *engine_, recorder, control, report_);
      control.from = end;
      facts_.device_bytes = std::max(facts_.device_bytes, engine_->device_bytes());
    } while (next_pass());
    facts_.simulate_s = watch.seconds();
    progress.finish();
    constexpr double kWorthSaving_s = 1;  // what follows may be interrupted as well
    if (facts_.simulate_s > kWorthSaving_s) save(end);
    facts_.checkpoints_s = checkpoints_.seconds();
    report_.note(checkpoints_.cost());
    recorder.close();
    warn_of_peaks(scene_, recorder.totals(), report_);
    if (outputs_) outputs_->snapshots_written(end.frame);  // also where that is frame 0
    print_report();
  }

  /// Changes the tool. Returns false after the last pass.
  bool next_pass() {
    if (scene_.later_passes.empty()) return false;
    engine_.reset();
    begin_next_pass(scene_);
    engine_ = load_engine(scene_, resources_.devices);
    return true;
  }

  void write(const Recorder& recorder) {
    measure(facts_, scene_, outputs_ ? outputs_->fill_before() : fill_before_, recorder.totals());
    engine_.reset();  // its copy of the fill is not needed any more, and writing needs memory
    return_free_memory();
    const Stopwatch watch;
    if (keep_.grids || keep_.pictures) write_results(dir_, scene_, recorder, facts_);
    return_free_memory();
    facts_.write_s = watch.seconds();
    if (outputs_) outputs_->finish_run(scene_.bone.fill);
    // The path of a push or of a tool on springs, and so its pictures, are known only now.
    if (keep_.pictures && !scenario_.motion.is_prescribed()) outputs_.emplace(Outputs::of_finished(scene_, dir_));
  }

  /// Makes pictures, plots and meshes, and writes summary.json, also where those fail.
  void render(const RunTotals& totals) {
    const Stopwatch watch;
    const auto finish = [&] {
      facts_.render_s = watch.seconds();
      facts_.render_context = outputs_->render_context();
      finish_summary(totals);
    };
    try {
      outputs_->make(report_, console_);
    } catch (const RunError&) {
      finish();
      throw;
    } catch (const std::bad_alloc&) {
      finish();
      const std::string limit = address_space_note();
      throw RunError(dir_ + ": not enough memory for pictures and meshes; " +
                     (limit.empty() ? "" : limit + ": raise it, or ") +
                     "use smaller pictures, larger voxels, or output.meshes: false");
    }
    finish();
    outputs_->make_report();
  }

  void finish_summary(const RunTotals& totals) {
    print_report();
    write_summary(dir_, scene_, totals, facts_);
  }

  /// Removes the logs that are not kept.
  void remove_logs() const {
    std::error_code ignored;
    if (!keep_.forces && !keep_.pictures) fs::remove(dir_ + "/forces.csv", ignored);
    if (keep_.pictures) return;
    fs::remove(dir_ + "/timings.csv", ignored);
    fs::remove_all(dir_ + "/snapshots", ignored);
  }

  [[nodiscard]] double mean_travel_mm() const {
    return averaged_travel_mm(scenario_.cutting, scene_.bone.voxmap->grid.voxel_mm);
  }

  /// Keeps the warnings so far for summary.json, and prints them.
  void print_report() {
    facts_.warnings.insert(facts_.warnings.end(), report_.warnings.begin(), report_.warnings.end());
    console_.print(report_);
  }

  const std::string& dir_;
  const Scenario& scenario_;
  KeptFiles keep_;
  RunResources& resources_;
  RunCheckpoints& checkpoints_;
  const Console& console_;
  Report report_;
  RunFacts facts_;
  ReamingScene scene_;
  std::vector<ContactForecast> contacts_;  ///< by pass
  FillBricks fill_before_;                 ///< of the bone, where there are no outputs
  std::optional<Outputs> outputs_;         ///< where they are kept
  std::unique_ptr<Engine> engine_;
  bool simulates_ = false;
};

/// What an interrupted run leaves.
StopOutcome outcome_of(const RunCheckpoints& checkpoints, const OutputFolder& folder) {
  if (const auto frame = checkpoints.saved_frame()) {
    return {kSuspendedStatus,
            fmt::format("interrupted; frame {} is saved in {}; the same command with --resume continues", *frame,
                        folder.path())};
  }
  if (!folder.has_frames()) return {};
  return {kInterruptedStatus, "interrupted; finished frames are in " + folder.path()};
}

/// Moves results to their place that were complete when their process was killed.
void finish_complete(OutputFolder& folder, const Scenario& scenario, const Console& console) {
  folder.keep();
  if (!is_result_of(folder.path(), scenario)) {
    throw InputError({folder.path(), 0, 0}, "--resume", "holds the complete results of another scenario",
                     "rename it, or start again with --overwrite and without --resume");
  }
  finish(folder, console);
  console.say("the results were complete: " + folder.final_path());
}

/// The last lines of a run. Scripts and the Python package take the folder from the first one.
void say_where_to_look(const std::string& dir, const Console& console) {
  const char* const first = fs::exists(dir + "/report.html") ? "report.html" : "summary.json";
  console.say("results: " + dir);
  console.say("look first at " + dir + "/" + first);
}

}  // namespace

std::optional<std::int64_t> run_scenario(const RunRequest& request, RunResources& resources, const Console& console) {
  const Scenario& scenario = request.scenario;
  OutputFolder folder({.dir = request.dir,
                       .kind = ResultKind::run,
                       .overwrite = request.overwrite,
                       .resume = request.resume,
                       .inputs = files_read(scenario),
                       .durable = request.durable});
  console.say("reamsim " REAMSIM_VERSION ": " + scenario.name + " -> " + folder.final_path());
  if (folder.is_complete()) {
    finish_complete(folder, scenario, console);
    return std::nullopt;
  }
  RunCheckpoints checkpoints(folder.path(), scenario.output.checkpoint_s, request.resume);
  const std::optional<std::int64_t> continued_after = checkpoints.saved_frame();
  if (continued_after) {
    console.say("continued after frame " + std::to_string(*continued_after));
    folder.keep();
  } else {
    folder.clear();
  }
  const ForcedStop forced([&] {
    const StopOutcome outcome = outcome_of(checkpoints, folder);
    folder.abandon();
    return outcome;
  });
  ScenarioRun run(folder.path(), request, resources, checkpoints, console);
  try {
    run.run();
  } catch (const Interrupted&) {
    folder.keep();
    const StopOutcome outcome = outcome_of(checkpoints, folder);
    if (outcome.status == kSuspendedStatus) throw Suspended(outcome.message);
    throw Interrupted(outcome.message);
  } catch (const std::exception& error) {
    if (!run.simulates() || !folder.has_frames()) throw;
    folder.keep();
    throw RunError(message_of(error) + "; finished frames are kept in " + folder.path());
  }
  if (request.keep.pictures)
    write_citation(folder.path(), cite_results(folder.path()));  // else the folder of the study has it
  finish(folder, console, [&] {
    Report report;
    checkpoints.remove(report);
    console.print(report);
  });
  say_where_to_look(folder.final_path(), console);
  return continued_after;
}

}  // namespace reamsim
