// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "sim/base/error.h"
#include "sim/engine/common/engine.h"
#include "sim/record/output_folder.h"
#include "sim/scenario/scenario.h"
#include "sim/scene/load_bone.h"
#include "sim/scene/scene.h"

namespace reamsim {

struct RunRequest {
  Scenario scenario;
  std::string dir;
  bool overwrite = false;  ///< an older run in the folder is replaced once this one succeeds
  bool resume = false;     ///< an interrupted run is continued from its last checkpoint
  KeptFiles keep{};
  bool durable = true;                  ///< the results are on the disk on return
  std::vector<std::string> warnings{};  ///< of the request, for summary.json
};

/// What runs that follow one another in a process share.
struct RunResources {
  EngineDevices devices;
  BoneCache* bones = nullptr;  ///< only where the next run may have the same bone
};

/// Pictures, plots, meshes and report of a run. `sim` has no renderer, so the caller of run_scenario() gives one.
class PictureSink {
 public:
  virtual ~PictureSink() = default;
  /// The bone comes from a CT that was segmented as `scene.bone.segmentation` says.
  virtual void draw_segmentation(const SimulationInput& scene, const std::string& dir) = 0;
  /// The run is about to begin, along poses that are known. DIR/snapshots/tool.stl exists.
  virtual void begin(const SimulationInput& scene, const std::string& dir) = 0;
  /// After begin(): all snapshots up to and including this frame's are on disk.
  virtual void snapshots_written(std::int64_t frame) = 0;
  /// After begin(): forces.csv is complete.
  virtual void forces_written() = 0;
  /// Ends what forces_written() began, before the results folder is released. make() does so as well.
  virtual void wait() = 0;
  /// The run has ended, and all its results are on disk. Called without begin() where the poses were not known.
  virtual void end(const SimulationInput& scene, const std::string& dir) = 0;
  /// Makes everything but the report, of which it makes what takes time. `report` gets the warnings. Throws RunError
  /// and Interrupted.
  virtual void make(Diagnostics& report) = 0;
  /// After make(): what rendered the pictures, empty where there are none.
  [[nodiscard]] virtual std::string render_context() const = 0;
  /// DIR/summary.json is complete.
  virtual void make_report() = 0;
};

/// Follows a run, and may interrupt it. This one does neither.
class RunMonitor {
 public:
  RunMonitor() = default;
  virtual ~RunMonitor() = default;
  RunMonitor(const RunMonitor&) = delete;
  RunMonitor& operator=(const RunMonitor&) = delete;

  /// A line about what the run does, or has found.
  virtual void say(const std::string& /*line*/) {}
  /// Warnings and notes of a stage.
  virtual void take(const Diagnostics& /*report*/) {}
  /// Finished frames of all. 0: the simulation begins.
  virtual void progress(std::int64_t /*done*/, std::int64_t /*total*/) {}
  /// True interrupts the run: run_scenario() throws Interrupted.
  [[nodiscard]] virtual bool stop_requested() { return false; }
  /// While the object exists, the run saves what a signal that ends the process would lose.
  [[nodiscard]] virtual std::shared_ptr<void> saving() { return nullptr; }
  /// While the object exists, `end`, on another thread, releases the output folder before the process ends by force.
  [[nodiscard]] virtual std::shared_ptr<void> on_forced_end(std::function<InterruptedRun()> /*end*/) { return nullptr; }
};

/// The results folder of a scenario for which none is named: its output.dir, else out/NAME.
std::string results_dir(const Scenario& scenario);

/// Loads, simulates, writes and draws (without `pictures`: does not). Throws InputError, RunError, Interrupted, and
/// Suspended where a checkpoint is left. Returns the frame after which an interrupted run was continued.
std::optional<std::int64_t> run_scenario(const RunRequest& request, RunResources& resources, RunMonitor& monitor,
                                         PictureSink* pictures);

}  // namespace reamsim
