// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>

#include "sim/run/simulation.h"

namespace reamsim::bench {

/// The first frames in contact are left out: caches and clocks of the processor are not as they will be.
inline constexpr std::size_t kWarmUpFrames = 20;

/// Wall time of a frame alone: pose in, force out, nothing batched and no windows, as a haptic device needs it.
struct Latency {
  std::int64_t frames = 0;  ///< in contact, that were timed
  double median_ms = 0;
  double p99_ms = 0;
  double p999_ms = 0;
  double most_ms = 0;
};

/// Moves the tool of the scene along its motion frame by frame, and times those in contact but the first 20, in which
/// memory of the device grows. Ends after `most` of them. Throws Interrupted, RunError.
Latency frame_latency(SimulationInput& scene, Engine& engine, std::int64_t most, const std::function<bool()>& stop);

}  // namespace reamsim::bench
