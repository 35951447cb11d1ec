// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/outputs.h"

#include <filesystem>
#include <system_error>

#include "render/pictures/figures.h"
#include "render/plots/plots.h"
#include "sim/base/error.h"
#include "sim/record/recorder.h"
#include "sim/run/checkpoint.h"
#include "sim/scenario/parse.h"
#include "sim/scene/contact_forecast.h"

namespace reamsim {

namespace {

/// Calls a function on a thread of its own. Throws std::bad_alloc where there is no room for one.
template <class Function>
auto on_thread(Function function) {
  try {
    return std::async(std::launch::async, std::move(function));
  } catch (const std::system_error&) {
    throw std::bad_alloc();
  }
}

constexpr const char* kNoSpectrum =
    "no torque spectrum: the tool does not rotate, or contact lasts less than four revolutions, or a revolution takes "
    "more than 100,000 frames";

/// The pose as read from forces.csv, so that re-rendered pictures are byte-identical.
ToolPose as_logged(ToolPose pose) {
  pose.orientation.normalize();
  // Turns −0, which the file does not have, into 0.
  pose.position_mm.array() += 0.0;
  pose.orientation.coeffs().array() += 0.0;
  pose.spin_angle_rad += 0.0;
  return pose;
}

/// The poses of a motion, which are known before the run.
void add_planned_path(const SimulationInput& scene, RunPath& path) {
  const auto add = [&](const Motion& motion) {
    for (std::int64_t frame = motion.first_frame; frame <= motion.last_frame(); ++frame) {
      path.add(as_logged(motion.pose_of(frame)), frame, motion.pass);
    }
  };
  add(scene.motion);
  for (const Pass& pass : scene.later_passes) add(pass.motion);
}

template <class AddPath>
RunInputs inputs_with(const SimulationInput& scene, const std::string& dir, std::vector<ToolPass> tools,
                      std::vector<std::int64_t> frames, const AddPath& add_path) {
  RunInputs run;
  run.dir = dir;
  run.voxmap = scene.bone.voxmap;
  run.fill = scene.bone.fill;
  run.whole_voxels = scene.scenario.cutting.erosion != ErosionMode::exact;
  run.glenoid = scene.bone.glenoid;
  run.side = scene.bone.side;
  run.frames = std::move(frames);
  run.passes = std::move(tools);
  RunPath path(run);
  add_path(path);
  path.give(run);
  return run;
}

/// The inputs of a push or a tool on springs up to `last_frame`: what the tool has not yet done is not known.
RunInputs inputs_so_far(const SimulationInput& scene, const std::string& dir, std::int64_t last_frame) {
  return inputs_with(scene, dir, read_tools(dir), snapshot_frames(dir), [&](RunPath& path) {
    for_each_force_row(dir + "/forces.csv", [&](const ForceRow& row) {
      if (row.frame <= last_frame) path.add(row.pose, row.frame, row.pass);
    });
  });
}

/// What pictures of a run need before it begins. DIR/snapshots/tool.stl must exist.
RunInputs inputs_of(const SimulationInput& scene, const std::string& dir) {
  return inputs_with(scene, dir, read_tools(dir),
                     picture_frames(scene.scenario.render, scene.last_frame(), scene.contact),
                     [&](RunPath& path) { add_planned_path(scene, path); });
}

OutputOptions output_options_of(const SimulationInput& scene) {
  const Scenario& scenario = scene.scenario;
  return {.pictures = {.settings = scenario.render},
          .plots = scenario.output.plots,
          .depth_map = scenario.render.enabled,
          .torque_spectrum = scenario.tool.spin == ToolSpin::resolved,
          .meshes = scenario.output.meshes};
}

}  // namespace

RunInputs inputs_without_folder(const SimulationInput& scene) {
  std::vector<ToolPass> tools{{.tool = scene.tool.mesh}};
  for (const Pass& pass : scene.later_passes) tools.push_back({.tool = pass.tool.mesh});
  return inputs_with(scene, "", std::move(tools), {0}, [&](RunPath& path) { add_planned_path(scene, path); });
}

bool is_unfinished(const std::string& dir) {
  return !std::filesystem::exists(dir + "/reamed.vdb");
}

RunData open_run(const std::string& dir) {
  const std::optional<Checkpoint> checkpoint = is_unfinished(dir) ? CheckpointFiles(dir).read() : std::nullopt;
  if (!checkpoint) return {dir};
  Diagnostics report;
  SimulationInput scene = load_scene(parse_scenario(dir + "/scenario.yaml", {}), report);
  const std::int64_t last = checkpoint->simulation.frame;
  scene.contact = contact_frames(forecast_passes(scene));
  // With the poses to come, where they are known, so that views and legend are those of the run.
  RunInputs inputs = scene.scenario.motion.is_prescribed() ? inputs_of(scene, dir) : inputs_so_far(scene, dir, last);
  std::erase_if(inputs.frames, [&](std::int64_t frame) { return frame > last; });
  RunData run(std::move(inputs));
  run.finish_log();
  restore_fill(*checkpoint, scene.bone.fill, dir);
  run.finish(std::move(scene.bone.fill));
  return run;
}

void Outputs::draw_segmentation(const SimulationInput& scene, const std::string& dir) {
  if (scene.scenario.render.enabled) write_segmentation_picture(dir, *scene.bone.segmentation);
}

void Outputs::begin(const SimulationInput& scene, const std::string& dir) {
  options_ = output_options_of(scene);
  run_.emplace(inputs_of(scene, dir));
  const bool draws = options_.pictures.settings.enabled;
  if (draws || options_.meshes) run_->predict();
  if (draws) render_thread_ = std::make_unique<RenderThread>(*run_, options_.pictures);
}

void Outputs::snapshots_written(std::int64_t frame) {
  if (render_thread_) render_thread_->snapshots_written(frame);
}

void Outputs::forces_written() {
  run_->finish_log();
  try {
    start_plots();
  } catch (const std::bad_alloc&) {  // make() tries again, when the results are on disk
  }
}

void Outputs::end(const SimulationInput& scene, const std::string& dir) {
  if (run_) return run_->finish(scene.bone.fill);
  options_ = output_options_of(scene);
  run_.emplace(dir);
}

void Outputs::start_plots() {
  plots_ = on_thread([this] { return make_plots(); });
}

Diagnostics Outputs::make_plots() const {
  Diagnostics report;
  const std::string& dir = run_->dir();
  // gnuplot gets the Ctrl-C of a terminal as well.
  const auto unless_stopped = [](const auto& plot) {
    try {
      plot();
    } catch (const RunError&) {
      if (!stop_requested()) throw;
    }
    if (stop_requested()) throw Interrupted();
  };
  if (options_.plots || draft_) unless_stopped([&] { write_force_plots(dir, run_->log()); });
  if (!options_.plots || !options_.pictures.settings.enabled) return report;
  unless_stopped([&] { write_depth_and_energy_plots(dir, run_->log()); });
  // Only a push has events.
  write_feedback_plots(dir, {.push = std::filesystem::exists(dir + "/events.csv"),
                             .springs = run_->log().rows.front().deflection_mm.has_value()});
  if (options_.torque_spectrum && !write_torque_spectrum(dir)) report.warn(kNoSpectrum);
  return report;
}

nlohmann::ordered_json Outputs::make_bone(Diagnostics& report) const {
  const double depth_max_mm = options_.pictures.settings.depth_max_mm;
  // First, because meshes take less memory beside the last pictures.
  nlohmann::ordered_json out = reports() ? bone_data(*run_, report_settings()) : nullptr;
  if (options_.depth_map && options_.finished) write_depth_picture(*run_, depth_max_mm);
  if (options_.meshes && options_.finished) write_meshes(*run_, depth_max_mm, report);
  if (options_.plots && options_.pictures.settings.enabled) {  // last, because gnuplot may fail
    write_removed_density(run_->dir(), {run_->voxmap(), run_->last_fill(), run_->inputs().fill});
  }
  return out;
}

void Outputs::make_pictures(Diagnostics& report) {
  Progress progress(console_, "render", "pictures");
  const auto tell = [&](int done, int total, const std::string&) {
    progress.update(done, total);
    if (stop_requested()) throw Interrupted();
  };
  if (reports()) {
    options_.pictures.written = [&](const std::string& path, PixelImage& image) {
      keep_page_picture(run_->dir(), path, image, page_pictures_);
    };
  }
  render_context_ = render_pictures(*run_, options_.pictures, tell, &report, render_thread_.get());
  progress.finish();
}

void Outputs::make(Diagnostics& report) {
  const RenderSettings& settings = options_.pictures.settings;
  if (!plots_.valid()) start_plots();
  std::future<Diagnostics> plots = std::move(plots_);
  Diagnostics of_bone;
  std::future<nlohmann::ordered_json> bone = on_thread([&] { return make_bone(of_bone); });
  if (settings.enabled) make_pictures(report);
  if (reports()) {
    report_ = report_parts(
        *run_, report_settings(), [&] { return bone.get(); }, page_pictures_);
  } else {
    bone.get();
  }
  Diagnostics of_plots = plots.get();
  for (const Diagnostics* part : {&of_bone, &of_plots}) {
    report.warnings.insert(report.warnings.end(), part->warnings.begin(), part->warnings.end());
  }
}

bool Outputs::reports() const {
  return options_.pictures.settings.enabled && options_.pictures.settings.report && options_.finished;
}

RenderSettings Outputs::report_settings() const {
  RenderSettings settings = options_.pictures.settings;
  if (!options_.report_cameras.empty()) settings.cameras = options_.report_cameras;
  return settings;
}

void Outputs::make_report() {
  if (report_) write_report(*run_, report_settings(), *report_);
}

void RunConsole::say(const std::string& line) {
  progress_.reset();
  console_.say(line);
}

void RunConsole::take(const Diagnostics& report) {
  progress_.reset();
  Diagnostics printed = report;
  console_.print(printed);
}

void RunConsole::progress(std::int64_t done, std::int64_t total) {
  if (!progress_) progress_.emplace(console_, "simulate", "frames");
  if (done > 0) progress_->update(done, total);
}

}  // namespace reamsim
