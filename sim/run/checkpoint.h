// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/stopwatch.h"
#include "sim/bone/voxmap/sparse_bricks.h"
#include "sim/record/recorder.h"
#include "sim/record/summary.h"
#include "sim/run/simulation.h"

namespace reamsim {

/// What must be the same for a run to continue from a checkpoint.
struct RunIdentity {
  std::string program;           ///< name and version
  std::string device;            ///< of OpenCL, or "serial"
  std::string scenario;          ///< resolved, YAML
  std::vector<InputSum> inputs;  ///< without the scenario file

  static auto fields(auto& self) { return std::tie(self.program, self.device, self.scenario, self.inputs); }
};

/// A brick of fill; coordinates in bricks.
using PlacedBrick = std::pair<Vec3i, FillBricks::Brick>;

/// The state of a run after a frame.
struct Checkpoint {
  RunIdentity identity;
  SimulationState simulation;
  LogLengths logs;
  std::vector<std::string> warnings;
  RemovedFrames removed;
  std::vector<PlacedBrick> fill;  ///< those that the run has changed
  std::vector<Vec3i> changed;     ///< bricks that changed since the last snapshot

  static auto fields(auto& c) {
    return std::tie(c.identity, c.simulation, c.logs, c.warnings, c.removed, c.fill, c.changed);
  }
};

/// The bricks of `now` that differ from those before the run.
std::vector<PlacedBrick> reamed_bricks(const FillBricks& before, const FillBricks& now);
/// Sets the fill to that of the checkpoint. `fill`: that before the run. Throws InputError where it has other bricks.
void restore_fill(const Checkpoint& checkpoint, FillBricks& fill, const std::string& dir);

/// DIR/checkpoint-0.bin and DIR/checkpoint-1.bin: a new one replaces the older, so that one is always complete.
class CheckpointFiles {
 public:
  explicit CheckpointFiles(std::string dir) : dir_(std::move(dir)) {}

  [[nodiscard]] std::optional<Checkpoint> read();
  /// Returns its length in bytes, when it is on the disk. Throws RunError.
  std::size_t write(const Checkpoint& checkpoint);
  void remove(Diagnostics& report) const;

 private:
  [[nodiscard]] std::string path(int number) const { return dir_ + "/checkpoint-" + std::to_string(number) + ".bin"; }

  std::string dir_;
  int next_ = 0;  ///< number of the next one to write
};

/// The checkpoints of a run: saves its state from time to time, and continues an interrupted run from the last one.
class RunCheckpoints {
 public:
  /// `every_s`: wall time between two checkpoints; 0: none. `resume`: continues the last one, if there is one.
  RunCheckpoints(const std::string& dir, double every_s, bool resume);

  /// Sets what identifies the run. Throws InputError where the checkpoint to continue is one of another run.
  void identify(const Scenario& scenario, const std::vector<InputSum>& inputs);
  /// Notes the device of the run. Warns where the checkpoint to continue is from another one.
  void use_device(const std::string& device, Diagnostics& report);
  /// Sets the fill of the bone, before the engine is made.
  void restore(FillBricks& fill);
  /// The logs of the run, new or those of the checkpoint, with what its scenario asks for. `report` gets its warnings.
  Recorder open_logs(double voxel_mm, const Scenario& scenario, Diagnostics& report);
  /// The state to go on from; nullopt at the start.
  [[nodiscard]] std::optional<SimulationState> state() const {
    return last_ ? std::optional(last_->simulation) : std::nullopt;
  }

  [[nodiscard]] bool due() const { return every_s_ > 0 && since_last_.seconds() >= every_s_; }
  /// Saves the state, unless no checkpoints are wanted. Returns whether it did. Throws RunError.
  bool save(const SimulationState& state, Recorder& recorder, const BoneView& bone, const Diagnostics& report);
  /// The frame of the last checkpoint, or nullopt.
  [[nodiscard]] std::optional<std::int64_t> saved_frame() const { return saved_frame_; }
  [[nodiscard]] std::string cost() const;
  [[nodiscard]] double seconds() const { return seconds_; }
  void remove(Diagnostics& report) const { files_.remove(report); }

 private:
  std::string dir_;
  double every_s_;
  CheckpointFiles files_;
  std::optional<Checkpoint> last_;
  RunIdentity identity_;
  Stopwatch since_last_;
  std::optional<std::int64_t> saved_frame_;
  int written_ = 0;
  double seconds_ = 0;
  std::size_t largest_bytes_ = 0;
};

}  // namespace reamsim
