// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <future>
#include <optional>

#include "cli/console.h"
#include "render/render.h"
#include "render/viewer/page.h"
#include "sim/run/run_scenario.h"

namespace reamsim {

/// Which outputs a command makes beside the results.
struct OutputOptions {
  PictureOptions pictures{};  ///< settings.enabled: pictures, report, and plots beside that of the forces against time
  bool plots = true;
  bool depth_map = true;
  bool torque_spectrum = true;
  bool meshes = true;
  std::vector<CameraView> report_cameras{};  ///< of the run, whose pictures the report shows; none: those of `pictures`
  bool finished = true;  ///< false: a run with a checkpoint only; no depth map, meshes or report can be made
};

/// What pictures need of a scene that is only looked at: without a folder, and with the snapshot of frame 0 only.
RunInputs inputs_without_folder(const SimulationInput& scene);

/// Whether DIR holds a run that can only be rendered from its checkpoint.
bool is_unfinished(const std::string& dir);
/// The run in DIR. The bone of an unfinished one is loaded again. Throws InputError.
RunData open_run(const std::string& dir);

/// A run on the terminal: its lines and progress, and the signals that interrupt it.
class RunConsole : public RunMonitor {
 public:
  explicit RunConsole(const Console& console) : console_(console) {}

  void say(const std::string& line) override;
  void take(const Diagnostics& report) override;
  void progress(std::int64_t done, std::int64_t total) override;
  [[nodiscard]] bool stop_requested() override { return reamsim::stop_requested(); }
  [[nodiscard]] std::shared_ptr<void> saving() override { return stop_grace(); }
  [[nodiscard]] std::shared_ptr<void> on_forced_end(std::function<InterruptedRun()> end) override {
    return on_forced_stop(std::move(end));
  }

 private:
  const Console& console_;
  std::optional<Progress> progress_;  ///< of the simulation
};

/// Makes pictures, plots, meshes and report of a run. A thread renders frames as soon as their snapshots are written.
class Outputs : public PictureSink {
 public:
  /// For a run that is simulated, with the outputs that its scenario asks for; a draft always plots its forces.
  Outputs(const Console& console, bool draft) : console_(console), draft_(draft) {}
  /// For a finished run.
  Outputs(const Console& console, RunData run, OutputOptions options)
      : console_(console), options_(std::move(options)), run_(std::move(run)) {}

  void draw_segmentation(const SimulationInput& scene, const std::string& dir) override;
  void begin(const SimulationInput& scene, const std::string& dir) override;
  void snapshots_written(std::int64_t frame) override;
  /// Starts the plots, beside what follows.
  void forces_written() override;
  void wait() override { plots_ = {}; }
  void end(const SimulationInput& scene, const std::string& dir) override;
  /// Other threads make plots, meshes and the bone of the report meanwhile. Throws InputError for a missing or damaged
  /// result, RunError and Interrupted, always after all threads have ended.
  void make(Diagnostics& report) override;
  [[nodiscard]] std::string render_context() const override { return render_context_; }
  /// Writes report.html if the options ask for it.
  void make_report() override;

 private:
  void start_plots();
  /// What is plotted of forces.csv. Returns warnings.
  [[nodiscard]] Diagnostics make_plots() const;
  /// Depth map, meshes and the plot of the removed bone. Returns the bone of the report, or null.
  [[nodiscard]] nlohmann::ordered_json make_bone(Diagnostics& report) const;
  void make_pictures(Diagnostics& report);
  [[nodiscard]] bool reports() const;
  [[nodiscard]] RenderSettings report_settings() const;

  const Console& console_;
  bool draft_ = false;
  OutputOptions options_;
  std::optional<RunData> run_;
  std::string render_context_;
  PagePictures page_pictures_;
  std::optional<ReportParts> report_;
  std::unique_ptr<RenderThread> render_thread_;  ///< during a simulation with pictures
  std::future<Diagnostics> plots_;               ///< uses run_; its destructor waits
};

}  // namespace reamsim
