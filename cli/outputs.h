// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "cli/console.h"
#include "render/pictures/run_view.h"
#include "render/render_thread.h"
#include "sim/scene/scene.h"

namespace reamsim {

/// Which outputs a command makes beside the results.
struct OutputOptions {
  PictureOptions pictures{};
  bool render = true;       ///< make those pictures
  bool force_plots = true;  ///< the forces against time
  bool all_plots = true;    ///< depth map, forces over depth, energy, density of the removed bone
  bool torque_spectrum = true;
  bool meshes = true;
  bool report = true;
  std::vector<CameraView> report_cameras{};  ///< of the run, whose pictures the report shows; none: those of `pictures`
  bool finished = true;  ///< false: a run with a checkpoint only; no depth map, meshes or report can be made
};

/// What pictures of a run need before it begins. DIR/snapshots/tool.stl must exist.
RunInputs inputs_of(const SimulationInput& scene, const std::string& dir);
/// The same of a scene that is only looked at: without a folder, and with the snapshot of frame 0 only.
RunInputs inputs_without_folder(const SimulationInput& scene);

/// Whether DIR holds a run that can only be rendered from its checkpoint.
bool is_unfinished(const std::string& dir);
/// The run in DIR. The bone of an unfinished one is loaded again. Throws InputError.
RunData open_run(const std::string& dir);

/// Makes pictures, plots, meshes and report of a run. A separate thread renders frames, during a simulation as soon as
/// their snapshots are written.
class Outputs {
 public:
  /// For a finished run.
  Outputs(RunData run, OutputOptions options) : run_(std::move(run)), options_(std::move(options)) {}
  /// For a run that is about to begin. DIR/snapshots/tool.stl must exist.
  Outputs(const SimulationInput& scene, const std::string& dir);

  /// For a run that has just ended in DIR, with all outputs that its scenario asks for.
  static Outputs of_finished(const SimulationInput& scene, const std::string& dir);

  /// All snapshots up to and including this frame's are on disk.
  void snapshots_written(std::int64_t frame);
  /// Fill of the bone before the run.
  [[nodiscard]] const FillBricks& fill_before() const { return run_.inputs().fill; }
  /// The run has ended with this fill, and all its results are on disk.
  void finish_run(const FillBricks& fill) { run_.finish(fill); }
  /// Makes everything but the report, with progress on the console. Another thread makes plots and meshes meanwhile.
  /// `report` gets all warnings. Throws InputError when a result is missing or damaged, RunError when an output cannot
  /// be made or written, and Interrupted; always after both threads have ended.
  void make(Diagnostics& report, const Console& console);
  /// After make(): what rendered the pictures, empty where there are none.
  [[nodiscard]] const std::string& render_context() const { return render_context_; }
  /// Writes report.html if the options ask for it. DIR/summary.json must be complete.
  void make_report() const;

  [[nodiscard]] double mean_travel_mm() const { return options_.pictures.mean_travel_mm; }

 private:
  [[nodiscard]] ForceLog log_with_means() const;
  void make_figures(Diagnostics& report) const;
  void make_pictures(Diagnostics& report, const Console& console);

  RunData run_;
  OutputOptions options_;
  std::string render_context_;
  std::unique_ptr<RenderThread> render_thread_;  ///< during a simulation with pictures
};

}  // namespace reamsim
