#pragma once

#include "sim/run/simulation.h"

namespace reamsim {

/// How many pictures a run of the scene will draw, each frame of a film counted.
int count_pictures(const ReamingScene& scene);

}  // namespace reamsim
