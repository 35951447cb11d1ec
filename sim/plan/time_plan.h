#pragma once

#include <cstdint>

#include "sim/run/simulation.h"

namespace reamsim {

/// How long the frames of a run will take, extrapolated from some of them.
struct TimePlan {
  double simulate_s = 0;          ///< all frames and their snapshots, pictures and results apart
  std::int64_t timed_frames = 0;  ///< of which windows were timed
  int windows = 0;
};

/// Runs short windows of frames, evenly spread over the motion, on the engine that a run would use, for about
/// `budget_s` seconds or a little more, and takes time per frame as linear between them. Each window begins with bone
/// as far as the window before has left it, less what its first pose removes. `engine` has the scene's bone; the bone
/// of both is reamed afterwards.
TimePlan plan_time(ReamingScene& scene, Engine& engine, double budget_s);

}  // namespace reamsim
