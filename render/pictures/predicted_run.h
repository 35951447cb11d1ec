// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "render/pictures/run_data.h"
#include "sim/scene/swept_bone.h"

namespace reamsim {

/// The bone after a run, predicted from the swept volume of its tools.
struct PredictedRun {
  PredictedBone bone;
  std::size_t pass = 0;  ///< index of the last one that removes bone
  FrameSpans contact;    ///< of the passes that touch the bone
};

/// Throws InputError when a tool has no swept volume.
PredictedRun predict_run(const RunInputs& run);

/// The farthest point of the tool from its origin, mm.
double tool_reach_mm(const TriangleMesh& tool);

}  // namespace reamsim
