// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

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
};

/// The bricks of `now` that differ from those before the run.
std::vector<PlacedBrick> reamed_bricks(const FillBricks& before, const FillBricks& now);
/// Sets the fill to that of the checkpoint. `fill`: that before the run. Throws InputError where it has other bricks.
void restore_fill(const Checkpoint& checkpoint, FillBricks& fill, const std::string& dir);

/// The two checkpoints of a run, DIR/checkpoint-0.bin and DIR/checkpoint-1.bin. A new one replaces the older, so that
/// one is always complete.
class CheckpointFiles {
 public:
  explicit CheckpointFiles(std::string dir) : dir_(std::move(dir)) {}

  /// The later undamaged checkpoint, or nullopt.
  [[nodiscard]] std::optional<Checkpoint> read();
  /// Returns its length in bytes, when it is on the disk. Throws RunError.
  std::size_t write(const Checkpoint& checkpoint);
  /// Warns where that is not possible.
  void remove(Diagnostics& report) const;

 private:
  [[nodiscard]] std::string path(int number) const;

  std::string dir_;
  int next_ = 0;  ///< number of the next one to write
};

/// Throws InputError where `saved` belongs to another run than `current`: the message names the key or input that
/// differs. The device may differ. `dir`: for messages.
void require_same_run(const RunIdentity& saved, const RunIdentity& current, const std::string& dir);

}  // namespace reamsim
