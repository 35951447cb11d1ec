#pragma once

#include "sim/engine/exact/exact_engine.h"
#include "sim/run/simulation.h"

namespace reamsim {

/// Follows the tool along its motion, about two voxels at a time; a brick counts from a little before the tool meets
/// it.
ExactForecast forecast_exact(const ReamingScene& scene);

}  // namespace reamsim
