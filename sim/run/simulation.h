#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "sim/engine/make_engine.h"
#include "sim/record/results.h"
#include "sim/scene/scene.h"

namespace reamsim {

/// What the caller of a run may watch and steer.
struct RunControl {
  /// Called after each batch with (frames done, frames in all).
  std::function<void(std::int64_t, std::int64_t)> progress = [](std::int64_t, std::int64_t) {};
  /// Asked after each batch; true ends the run with Interrupted.
  std::function<bool()> stop = [] { return false; };
  /// The user has been told already that the tool will never touch the bone (contact_forecast.h).
  bool foretold_no_contact = false;
};

/// make_engine() for the scene, whose mistakes stand at their keys. Throws InputError, RunError.
std::unique_ptr<Engine> load_engine(const ReamingScene& scene);

/// Runs the motion: per substep broad phase → enqueue, per batch collect → record. `scene.bone` is reamed; rows,
/// snapshots and timings go to `sink`. Warns when the tool never touches, starts inside bone, or cuts without spin.
void simulate(ReamingScene& scene, Engine& engine, FrameSink& sink, const RunControl& control, Report& report);

/// What a run will cost, from the motion alone.
struct RunCost {
  std::int64_t frames = 0;
  std::int64_t substeps = 0;
};
RunCost estimate_cost(const ReamingScene& scene);

}  // namespace reamsim
