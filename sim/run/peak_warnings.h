// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/base/error.h"
#include "sim/record/run_totals.h"
#include "sim/scene/scene.h"

namespace reamsim {

/// Warns where `exact` gives too large peaks of single frames: the tool advances too little in a frame, or resolved
/// edges lie along the voxels. The headline of other erosions is made of means.
void warn_of_peaks(const SimulationInput& scene, const RunTotals& totals, Diagnostics& report);

}  // namespace reamsim
