// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>

#include "sim/engine/exact/exact_engine.h"
#include "sim/run/simulation.h"

namespace reamsim {

/// Estimate of the peak memory of a run until its results and force plots are written, without pictures.
struct MemoryPlan {
  std::size_t device_bytes = 0;   ///< 0 for the serial engine
  std::size_t process_bytes = 0;  ///< within a third of measurements; includes device memory, as for a CPU
};
MemoryPlan plan_memory(const SimulationInput& scene);

/// The bricks that an `exact` run will cut, from the path of the tool at steps of about two voxels. Conservative.
ExactForecast forecast_exact(const SimulationInput& scene);

}  // namespace reamsim
