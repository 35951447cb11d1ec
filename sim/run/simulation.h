// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <tuple>

#include "sim/base/error.h"
#include "sim/engine/common/engine.h"
#include "sim/record/results.h"
#include "sim/record/run_totals.h"
#include "sim/run/balance.h"
#include "sim/run/frame_stepper.h"
#include "sim/scene/scene.h"

namespace reamsim {

struct SimulationState : StepState {
  FeedState feed = {};       ///< under thrust
  SpringState springs = {};  ///< of a tool on springs

  static auto fields(auto& self) { return std::tuple_cat(StepState::fields(self), std::tie(self.feed, self.springs)); }
};

struct RunControl {
  /// Called after each batch with (finished frames, all frames).
  std::function<void(std::int64_t, std::int64_t)> progress = [](std::int64_t, std::int64_t) {};
  /// Called after each batch; true ends the run with Interrupted, after `save`.
  std::function<bool()> stop = [] { return false; };
  /// Called after each batch; true asks for `save`.
  std::function<bool()> save_due = [] { return false; };
  /// Receives the state after a batch. The fill of the bone is up to date.
  std::function<void(const SimulationState&)> save = [](const SimulationState&) {};
  /// Continues after this state, of `save` or of the pass before; the fill of the bone must be that of the state.
  std::optional<SimulationState> from = {};
  /// The user has been warned already that the tool will never touch the bone (contact_forecast.h).
  bool warned_of_no_contact = false;
};

/// make_engine() for the scene, with mistakes located at their keys. Throws InputError, RunError.
std::unique_ptr<Engine> load_engine(const SimulationInput& scene, EngineDevices& devices);
std::unique_ptr<Engine> load_engine(const SimulationInput& scene);

/// Runs the present pass, the main loop: per substep broad phase → enqueue, per batch collect → record. A feed decides
/// the poses (feed.h). `scene.bone` is reamed. Warns when the tool never touches, starts inside bone, or cuts without
/// spin. Returns the state after the last frame.
SimulationState simulate(SimulationInput& scene, Engine& engine, FrameSink& sink, const RunControl& control,
                         Diagnostics& report);

/// Of all passes, along the planned poses.
std::int64_t count_all_substeps(const SimulationInput& scene);

/// Warns where `exact` gives too large peaks of single frames: tiny advances, or resolved edges along the voxels.
void warn_of_peaks(const SimulationInput& scene, const RunTotals& totals, Diagnostics& report);

}  // namespace reamsim
