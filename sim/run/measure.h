#pragma once

#include "sim/record/summary.h"

namespace reamsim {

/// Measures what the run did to the bone: metrics, depth map, and the time that takes. `fill_before`: the bone's fill
/// when the run began.
void measure(RunFacts& facts, const ReamingScene& scene, const FillBricks& fill_before, const RunTotals& totals);

}  // namespace reamsim
