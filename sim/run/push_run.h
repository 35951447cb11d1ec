// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/run/simulation.h"

namespace reamsim {

/// Runs a push (`motion.push`). In every frame it tries feeds on the present bone until the forces balance (hand.h),
/// and then cuts once. A feed whose advance in a frame is near the smallest loss that single precision tells would give
/// a force of few voxels at a time; such feeds are tried over a longer time at the same speed, past the first advance,
/// whose force includes what earlier frames left. Results do not depend on interruptions.
SimulationState run_push(ReamingScene& scene, Engine& engine, FrameSink& sink, const RunControl& control,
                         Report& report);

/// A tool that advances less under thrust stands still, mm/s; after this time it has stalled.
inline constexpr double kStill_mm_s = 1e-3, kStall_s = 0.1;

}  // namespace reamsim
