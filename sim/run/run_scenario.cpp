// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/run_scenario.h"

#include <fmt/core.h>
#include <algorithm>
#include <filesystem>
#include <new>

#include "sim/base/process.h"
#include "sim/base/stopwatch.h"
#include "sim/bone/bone.h"
#include "sim/record/citation.h"
#include "sim/record/run_totals.h"
#include "sim/record/summary.h"
#include "sim/run/checkpoint.h"
#include "sim/run/simulation.h"
#include "sim/scenario/parse.h"
#include "sim/scene/contact_forecast.h"

namespace reamsim {

namespace {

/// Measures the reamed bone: metrics, depth map, and the time of measuring.
void measure(RunFacts& facts, const SimulationInput& scene, const RunTotals& totals) {
  const Stopwatch watch;
  const BoneView bone = scene.bone.view();
  const Rigid bone_from_tool = totals.deepest_pose.bone_from_tool();
  BoneAxes axes{.scapula = scene.bone.scapula, .glenoid = {}};
  const BoneSource source = scene.scenario.bone.source;
  axes.version = scene.scenario.bone.glenoid.version_landmarks;
  axes.side_known = scene.bone.side != BodySide::unknown;
  axes.axial_z = source == BoneSource::ct || source == BoneSource::phantom;
  axes.rim_mm = scene.bone.rim_mm;
  if (scene.bone.glenoid) {
    axes.glenoid = axes_of(*scene.bone.glenoid, scene.bone.side);
    axes.bone_from_glenoid = scene.bone.glenoid->bone_from_glenoid;
    axes.face_center_mm = axes.bone_from_glenoid->translation();
  }
  if (scene.bone.landmarks) axes.face_center_mm = scene.bone.landmarks->glenoid_center_mm;
  const TriangleMesh* implant_mesh = scene.implant_mesh ? &*scene.implant_mesh : nullptr;
  facts.metrics = measure_bone(bone, bone_from_tool, axes, scene.scenario.metrics, implant_mesh);
  facts.depth_map = depth_map(bone, scene.bone.glenoid, bone_from_tool);
  facts.measure_s = watch.seconds();
}

namespace fs = std::filesystem;

std::vector<std::string> files_read(const Scenario& scenario) {
  std::vector<std::string> files{scenario.file};
  for (const auto& [role, path] : input_files(scenario)) files.push_back(path);
  return files;
}

/// The same figures, with the same names, as pictures, plots, summary and report have.
void say_summary(RunMonitor& monitor, const RunTotals& totals, const RunFacts& facts, bool means) {
  const KeyResults run = totals.headline(means);
  monitor.say(fmt::format("removed {:.1f} mm3; {} {} mm; {} {} N, {} {} N mm; energy balance {:.1e}",
                          totals.removed_mm3, run.depth().name, run.depth().number, run.force().name,
                          run.force().number, run.torque().name, run.torque().number, totals.balance));
  for (std::size_t i = 0; i < totals.passes.size() && totals.passes.size() > 1; ++i) {
    const PassTotals& pass = totals.passes[i];
    monitor.say(
        fmt::format("pass {}: removed {:.1f} mm3; tool depth {:.2f} mm; peak axial force {:.1f} N, peak spin "
                    "torque {:.0f} N mm",
                    i + 1, pass.removed_mm3, pass.max_depth_mm, pass.peak_axial_force_n, pass.peak_spin_torque_nmm));
  }
  monitor.say(fmt::format("{:.1f} s simulated in {:.1f} s on {}", totals.simulated_s, facts.simulate_s, facts.device));
}

class ScenarioRun {
 public:
  /// `pictures`: nullptr for none.
  ScenarioRun(const std::string& dir, const RunRequest& request, RunResources& resources, RunCheckpoints& checkpoints,
              RunMonitor& monitor, PictureSink* pictures)
      : dir_(dir),
        scenario_(request.scenario),
        keep_(request.keep),
        resources_(resources),
        checkpoints_(checkpoints),
        monitor_(monitor),
        pictures_(pictures) {
    report_.warnings = request.warnings;
  }
  ScenarioRun(const ScenarioRun&) = delete;
  ScenarioRun& operator=(const ScenarioRun&) = delete;
  ~ScenarioRun() {
    if (pictures_ != nullptr) pictures_->wait();
  }

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
    tell_report();
    facts_.bone_before_mm3 = scene_.bone.view().bone_mm3();
    if (keep_.pictures) write_tools(dir_, scene_);
    if (draws_during_run()) pictures_->begin(scene_, dir_);
    checkpoints_.restore(scene_.bone.fill);
    skip_finished_passes();
    engine_ = load_engine(scene_, resources_.devices);
    facts_.device = engine_->device();
    checkpoints_.use_device(facts_.device, report_);
    write_scenario(dir_, scene_, facts_);
    return_free_memory();
    facts_.load_s = watch.seconds();
  }

  Recorder open_logs() { return checkpoints_.open_logs(scene_.bone.voxmap->grid.voxel_mm, scenario_, report_); }

  void simulate_frames(Recorder& recorder) {
    simulates_ = true;
    const auto until_saved = monitor_.saving();
    const auto save = [&](const SimulationState& state) {
      const bool saved = checkpoints_.save(state, recorder, scene_.bone, report_);
      if (saved) write_summary(dir_, scene_, recorder.totals(), facts_, /*finished=*/false);
    };
    RunControl control{.save_due = [this] { return checkpoints_.due(); }, .save = save, .from = checkpoints_.state()};
    control.progress = [&](std::int64_t done, std::int64_t total) {
      if (draws_during_run()) pictures_->snapshots_written(done);
      monitor_.progress(done, total);
    };
    control.stop = [this] { return monitor_.stop_requested(); };
    monitor_.progress(0, scene_.last_frame());
    const Stopwatch watch;
    SimulationState end;
    do {
      control.warned_of_no_contact = !contacts_[static_cast<std::size_t>(scene_.motion.pass) - 1].touches;
      end = simulate(scene_, *engine_, recorder, control, report_);
      control.from = end;
      facts_.device_bytes = std::max(facts_.device_bytes, engine_->device_bytes());
    } while (next_pass());
    facts_.simulate_s = watch.seconds();
    constexpr double kWorthSaving_s = 1;  // what follows may be interrupted as well
    if (facts_.simulate_s > kWorthSaving_s) save(end);
    facts_.checkpoints_s = checkpoints_.seconds();
    report_.note(checkpoints_.cost());
    recorder.close();
    warn_of_peaks(scene_, recorder.totals(), report_);
    if (draws_during_run()) {
      pictures_->snapshots_written(end.frame);  // also where that is frame 0
      pictures_->forces_written();
    }
    tell_report();
  }

  void finish(const Recorder& recorder) {
    write(recorder);
    if (pictures_ != nullptr) {
      draw(recorder.totals());
    } else {
      finish_summary(recorder.totals());
    }
    remove_logs();
    report_.note(
        fmt::format("time: load {:.2f} s, simulate {:.2f} s, measure {:.2f} s, write {:.2f} s, render {:.2f} s; "
                    "total {:.2f} s",
                    facts_.load_s, facts_.simulate_s, facts_.measure_s, facts_.write_s, facts_.render_s,
                    facts_.since_start.seconds()));
    tell_report();
    say_summary(monitor_, recorder.totals(), facts_, scenario_.cutting.erosion != ErosionMode::exact);
  }

  [[nodiscard]] bool simulates() const { return simulates_; }
  /// The warnings of a run that failed: one may name the cause.
  [[nodiscard]] const Diagnostics& report() const { return report_; }

 private:
  /// The path of a push or of a tool on springs, and so its pictures, are known only at the end.
  [[nodiscard]] bool draws_during_run() const { return pictures_ != nullptr && scenario_.motion.is_prescribed(); }

  void skip_finished_passes() {
    const auto state = checkpoints_.state();
    while (state && !scene_.motion.push && state->frame >= scene_.motion.last_frame() && begin_next_pass(scene_)) {
    }
  }

  void find_clearance_of_holder() {
    facts_.clearance = find_clearance(scene_);
    if (!facts_.clearance) return;
    monitor_.say(sentence_of(*facts_.clearance, scene_));
    warn_of_clearance(*facts_.clearance, scene_, report_);
    write_clearance(dir_ + "/clearance.csv", *facts_.clearance, scene_.motion.frame_s());
  }

  void report_segmentation() const {
    const auto& segmentation = scene_.bone.segmentation;
    if (!segmentation) return;
    monitor_.say(sentence_of(*segmentation));
    if (pictures_ != nullptr) pictures_->draw_segmentation(scene_, dir_);
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
    measure(facts_, scene_, recorder.totals());
    const auto& planning = facts_.metrics.planning;
    if (std::string warning = planning ? planning->seating.warning() : ""; !warning.empty())
      report_.warn(std::move(warning));
    engine_.reset();  // its copy of the fill is not needed any more, and writing needs memory
    return_free_memory();
    const Stopwatch watch;
    if (keep_.grids || keep_.pictures) write_results(dir_, scene_, recorder, facts_);
    return_free_memory();
    facts_.write_s = watch.seconds();
    if (pictures_ != nullptr) pictures_->end(scene_, dir_);
  }

  /// Makes pictures, plots and meshes, and writes summary.json, also where those fail.
  void draw(const RunTotals& totals) {
    const Stopwatch watch;
    const auto finish = [&] {
      facts_.render_s = watch.seconds();
      facts_.render_context = pictures_->render_context();
      finish_summary(totals);
    };
    try {
      pictures_->make(report_);
    } catch (const RunError&) {
      finish();
      throw;
    } catch (const InputError&) {  // a picture that the report cannot read again
      finish();
      throw;
    } catch (const std::bad_alloc&) {
      finish();
      throw RunError(dir_ + ": not enough memory for pictures and meshes; " +
                     address_space_note("", ": raise it, or ") +
                     "use smaller pictures, larger voxels, or output.meshes: false");
    }
    finish();
    pictures_->make_report();
  }

  void finish_summary(const RunTotals& totals) {
    tell_report();
    write_summary(dir_, scene_, totals, facts_);
  }

  void remove_logs() const {
    std::error_code ignored;
    if (!keep_.forces && !keep_.pictures) fs::remove(dir_ + "/forces.csv", ignored);
    if (keep_.pictures) return;
    fs::remove(dir_ + "/timings.csv", ignored);
    fs::remove_all(dir_ + "/snapshots", ignored);
  }

  /// Keeps the warnings so far for summary.json, and gives them to the monitor.
  void tell_report() {
    facts_.warnings.insert(facts_.warnings.end(), report_.warnings.begin(), report_.warnings.end());
    monitor_.take(report_);
    report_ = {};
  }

  const std::string& dir_;
  const Scenario& scenario_;
  KeptFiles keep_;
  RunResources& resources_;
  RunCheckpoints& checkpoints_;
  RunMonitor& monitor_;
  PictureSink* pictures_;
  Diagnostics report_;
  RunFacts facts_;
  SimulationInput scene_;
  std::vector<ContactForecast> contacts_;  ///< by pass
  std::unique_ptr<Engine> engine_;
  bool simulates_ = false;
};

InterruptedRun what_remains(const RunCheckpoints& checkpoints, const OutputFolder& folder) {
  if (const auto frame = checkpoints.saved_frame()) {
    return {true, fmt::format("interrupted; frame {} is saved in {}; the same command with --resume continues", *frame,
                              folder.path())};
  }
  if (!folder.has_frames()) return {};
  return {false, "interrupted; finished frames are in " + folder.path()};
}

void take_on_error(RunMonitor& monitor, const Diagnostics& report) {
  try {
    monitor.take(report);
  } catch (const std::exception&) {  // no memory: the error itself is what counts
  }
}

void finish(OutputFolder& folder, RunMonitor& monitor, const std::function<void()>& remove_unfinished = {}) {
  Diagnostics report;
  if (std::string warning = folder.finish(remove_unfinished); !warning.empty()) report.warn(std::move(warning));
  monitor.take(report);
}

/// Moves results to their place that were complete when their process was killed.
void finish_complete(OutputFolder& folder, const Scenario& scenario, RunMonitor& monitor) {
  folder.keep();
  if (!is_result_of(folder.path(), scenario)) {
    throw InputError({folder.path(), 0, 0}, "--resume", "holds the complete results of another scenario",
                     "rename it, or start again with --overwrite and without --resume");
  }
  finish(folder, monitor);
  monitor.say("the results were complete: " + folder.final_path());
}

/// The last lines of a run. Scripts and the Python package take the folder from the first one.
void say_where_to_look(const std::string& dir, RunMonitor& monitor) {
  const char* const first = fs::exists(dir + "/report.html") ? "report.html" : "summary.json";
  monitor.say("results: " + dir);
  monitor.say("look first at " + dir + "/" + first);
}

}  // namespace

std::string results_dir(const Scenario& scenario) {
  return scenario.output.dir.empty() ? "out/" + scenario.name : scenario.output.dir;
}

std::optional<std::int64_t> run_scenario(const RunRequest& request, RunResources& resources, RunMonitor& monitor,
                                         PictureSink* pictures) {
  const Scenario& scenario = request.scenario;
  OutputFolder folder({.dir = request.dir,
                       .kind = ResultKind::run,
                       .overwrite = request.overwrite,
                       .resume = request.resume,
                       .inputs = files_read(scenario),
                       .durable = request.durable});
  monitor.say("reamsim " REAMSIM_VERSION ": " + scenario.name + " -> " + folder.final_path());
  if (folder.is_complete()) {
    finish_complete(folder, scenario, monitor);
    return std::nullopt;
  }
  RunCheckpoints checkpoints(folder.path(), scenario.output.checkpoint_s, request.resume);
  const std::optional<std::int64_t> continued_after = checkpoints.saved_frame();
  if (continued_after) {
    monitor.say("continued after frame " + std::to_string(*continued_after));
    folder.keep();
  } else {
    folder.clear();
  }
  const auto forced = monitor.on_forced_end([&] {
    InterruptedRun remains = what_remains(checkpoints, folder);
    folder.abandon();
    return remains;
  });
  ScenarioRun run(folder.path(), request, resources, checkpoints, monitor, request.keep.pictures ? pictures : nullptr);
  try {
    run.load();
    Recorder recorder = run.open_logs();
    run.simulate_frames(recorder);
    run.finish(recorder);
  } catch (const Interrupted&) {
    take_on_error(monitor, run.report());
    folder.keep();
    const InterruptedRun remains = what_remains(checkpoints, folder);
    if (remains.saved) throw Suspended(remains.message);
    throw Interrupted(remains.message);
  } catch (const std::exception& error) {
    take_on_error(monitor, run.report());
    if (!run.simulates() || !folder.has_frames()) throw;
    folder.keep();
    std::string message = message_of(error) + "; finished frames are kept in " + folder.path();
    if (const auto frame = checkpoints.saved_frame())
      message += fmt::format("; frame {} is saved: continue a run with --resume, a study by the same command", *frame);
    if (dynamic_cast<const cl::DeviceError*>(&error) != nullptr) throw cl::DeviceError(message);
    throw RunError(message);
  }
  if (request.keep.pictures)
    write_citation(folder.path(), cite_results(folder.path()));  // else the folder of the study has it
  finish(folder, monitor, [&] {
    Diagnostics report;
    checkpoints.remove(report);
    monitor.take(report);
  });
  say_where_to_look(folder.final_path(), monitor);
  return continued_after;
}

}  // namespace reamsim
