// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/run/simulation.h"

namespace reamsim {

/// Runs a pass whose tool is on springs (`motion.compliance`). A frame has the substeps of the planned motion; in each,
/// deflections are tried on the present bone until the forces balance (springs.h), and then the tool cuts once. A
/// substep whose motion is near the smallest loss that single precision tells is tried over a longer time at the same
/// velocity, as that of a push (push_run.h). Results do not depend on interruptions.
SimulationState run_compliant(ReamingScene& scene, Engine& engine, FrameSink& sink, const RunControl& control,
                              Report& report);

}  // namespace reamsim
