// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/record/summary.h"

namespace reamsim {

/// Measures the reamed bone: metrics, depth map, and the time of measuring. `fill_before`: the fill before the run.
void measure(RunFacts& facts, const SimulationInput& scene, const FillBricks& fill_before, const RunTotals& totals);

}  // namespace reamsim
