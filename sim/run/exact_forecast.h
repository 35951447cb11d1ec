#pragma once

#include <cstddef>

#include "sim/run/simulation.h"

namespace reamsim {

/// What a run with `erosion: exact` will do to the bone's bricks, at most.
struct ExactForecast {
  std::size_t parted = 0;  ///< bricks that are not whole or that the tool comes to: a page of fill each
  std::size_t listed = 0;  ///< bricks that the tool's surface can meet in one visit
};

/// Follows the tool along its motion, about two voxels at a time; a brick counts from a little before the tool meets
/// it.
ExactForecast forecast_exact(const ReamingScene& scene);

}  // namespace reamsim
