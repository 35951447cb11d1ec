// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "sim/engine/common/engine.h"
#include "sim/run/run_scenario.h"
#include "sim/run/simulation.h"

namespace reamsim {

/// Estimate of the run time of the frames, extrapolated from a part of them.
struct TimePlan {
  double simulate_s = 0;          ///< all frames of the pass and snapshots, without pictures and results
  std::int64_t timed_frames = 0;  ///< in the windows
  int windows = 0;
};

/// Runs short windows of frames, evenly spread over the present pass, for about `budget_s` seconds, and interpolates
/// the time per frame linearly. A window begins with the remaining bone of the previous one. `engine` has the scene's
/// bone; both are reamed afterwards.
TimePlan plan_time(SimulationInput& scene, Engine& engine, double budget_s);

/// Estimate of the peak memory of a run until its results and force plots are written, without pictures.
struct MemoryPlan {
  std::size_t device_bytes = 0;   ///< 0 for the serial engine
  std::size_t process_bytes = 0;  ///< within a third of measurements; includes device memory, as for a CPU
};
MemoryPlan plan_memory(const SimulationInput& scene);

/// The bricks that an `exact` run will cut, from the path of the tool at steps of about two voxels. Conservative.
ExactForecast forecast_exact(const SimulationInput& scene);

/// What a run would take.
struct RunEstimate {
  double load_s = 0;
  double simulate_s = 0;
  std::size_t memory_bytes = 0;  ///< of the process, without pictures
  std::int64_t frames = 0;
  std::vector<std::string> warnings;
};

/// Checks runs and estimates their cost. Of runs with the same bone, tool and force basis, only the first is timed.
class RunEstimator {
 public:
  /// `resources` must have a cache of bones. Throws InputError with every mistake of the scenario.
  RunEstimate estimate(const Scenario& scenario, RunResources& resources);

 private:
  double simulate_s(SimulationInput& scene, RunResources& resources);

  /// By bone (BoneCache::loaded), tool, and whether a force basis is written, which takes longer than the frames.
  std::map<std::tuple<int, std::string, bool>, double> s_per_frame_;
};

}  // namespace reamsim
