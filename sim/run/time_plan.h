// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>

#include "sim/run/simulation.h"

namespace reamsim {

/// Estimate of the run time of the frames, extrapolated from a part of them.
struct TimePlan {
  double simulate_s = 0;          ///< all frames of the pass and snapshots, without pictures and results
  std::int64_t timed_frames = 0;  ///< in the windows
  int windows = 0;
};

/// For the present pass. Runs short windows of frames, evenly spread over its motion, on the engine of the run for
/// about `budget_s` seconds, and interpolates the time per frame linearly. A window begins with the remaining bone of
/// the previous one, less the bone in its first pose. `engine` has the scene's bone; both are reamed afterwards.
TimePlan plan_time(SimulationInput& scene, Engine& engine, double budget_s);

}  // namespace reamsim
