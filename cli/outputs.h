#pragma once

#include "cli/console.h"
#include "render/pictures/run_view.h"
#include "render/render_thread.h"
#include "sim/scene/scene.h"

namespace reamsim {

/// What is to be made of a run beside its results.
struct OutputOptions {
  PictureOptions pictures{};
  bool render = true;       ///< make those pictures
  bool force_plots = true;  ///< the forces against time, and the depth map
  bool all_plots = true;    ///< forces over depth, energy, density of the removed bone
  bool torque_spectrum = true;
  bool meshes = true;
  bool report = true;
};

/// Makes a run's pictures, plots, meshes and report. Frames are rendered on a thread of their own, where the run is
/// simulated as soon as their snapshots are written.
class Outputs {
 public:
  /// Of a finished run.
  Outputs(RunData run, OutputOptions options) : run_(std::move(run)), options_(std::move(options)) {}
  /// Of a run that is about to begin. DIR/snapshots/tool.stl is there already.
  Outputs(const ReamingScene& scene, const std::string& dir);

  /// All snapshots up to and including this frame's are on disk.
  void snapshots_written(std::int64_t frame);
  /// The run has ended with this fill, and all its results are on disk.
  void finish_run(const FillBricks& fill) { run_.finish(fill); }
  /// Makes everything but the report, with progress on the console. Plots and meshes are made beside the pictures, on
  /// another thread: they keep one core busy, and rendering leaves one idle between its frames. `report` gets the
  /// warnings of all. Throws InputError when a result is missing or damaged, RunError when something cannot be made or
  /// written, and Interrupted; always after both threads have ended.
  void make(Report& report, const Console& console);
  /// Writes report.html where it is wanted. DIR/summary.json is complete.
  void make_report() const;

  [[nodiscard]] double mean_travel_mm() const { return options_.pictures.mean_travel_mm; }

 private:
  void make_figures(Report& report) const;
  void make_pictures(Report& report, const Console& console);

  RunData run_;
  OutputOptions options_;
  std::unique_ptr<RenderThread> render_thread_;  ///< of a run that is simulated, where pictures are wanted
};

}  // namespace reamsim
