// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/run_checkpoints.h"

#include <fmt/core.h>
#include <algorithm>
#include <filesystem>

#include "sim/scenario/parse.h"

namespace reamsim {

RunCheckpoints::RunCheckpoints(const std::string& dir, double every_s, bool resume)
    : dir_(dir), every_s_(every_s), files_(dir) {
  if (resume) last_ = files_.read();
  if (last_) saved_frame_ = last_->simulation.frame;
}

void RunCheckpoints::identify(const Scenario& scenario, const std::vector<InputSum>& inputs) {
  identity_ = {.program = "reamsim " REAMSIM_VERSION, .device = "", .scenario = to_yaml(scenario), .inputs = {}};
  for (const InputSum& input : inputs) {
    if (input.path != scenario.file) identity_.inputs.push_back(input);
  }
  if (last_) require_same_run(last_->identity, identity_, dir_);
}

void RunCheckpoints::use_device(const std::string& device, Diagnostics& report) {
  identity_.device = device;
  if (last_ && last_->identity.device != device) {
    report.warn("continued on " + device + "; the run began on " + last_->identity.device);
  }
}

void RunCheckpoints::restore(FillBricks& fill) {
  before_ = fill;
  if (!last_) return;
  restore_fill(*last_, fill, dir_);
  last_->fill.clear();
}

Recorder RunCheckpoints::open_logs(double voxel_mm, const Scenario& scenario, Diagnostics& report) {
  const PoseFeedback feedback{.push = scenario.motion.push.has_value(),
                              .springs = scenario.motion.compliance.has_value()};
  if (!last_) return {dir_, voxel_mm, scenario.output.force_basis, feedback};
  for (const std::string& warning : last_->warnings) report.warn(warning);
  // Left by an attempt that was killed after its simulation: with it, and rows behind the checkpoint removed, the
  // folder would look like that of a finished run.
  std::error_code ignored;
  std::filesystem::remove(dir_ + "/reamed.vdb", ignored);
  return {dir_, voxel_mm, last_->simulation.frame, last_->logs, std::move(last_->removed), feedback};
}

std::optional<SimulationState> RunCheckpoints::state() const {
  return last_ ? std::optional(last_->simulation) : std::nullopt;
}

bool RunCheckpoints::save(const SimulationState& state, Recorder& recorder, const FillBricks& fill,
                          const Diagnostics& report) {
  if (every_s_ <= 0 || saved_frame_ == state.frame) return false;
  const Stopwatch watch;
  const std::size_t bytes = files_.write({.identity = identity_,
                                          .simulation = state,
                                          .logs = recorder.sync(),
                                          .warnings = report.warnings,
                                          .removed = recorder.removed_frames(),
                                          .fill = reamed_bricks(before_, fill),
                                          .changed = fill.changed()});
  saved_frame_ = state.frame;
  since_last_ = Stopwatch();
  ++written_;
  seconds_ += watch.seconds();
  largest_bytes_ = std::max(largest_bytes_, bytes);
  return true;
}

std::string RunCheckpoints::cost() const {
  if (written_ == 0) return "no checkpoint was due";
  return fmt::format("checkpoints written: {}, {:.3f} s in all, the largest {:.2f} MB", written_, seconds_,
                     static_cast<double>(largest_bytes_) / 1e6);
}

}  // namespace reamsim
