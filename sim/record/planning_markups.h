// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/anatomy/run_metrics.h"
#include "sim/scene/scene.h"
#include "sim/tool/motion.h"

namespace reamsim {

/// The name of the markups that a run writes for 3D Slicer.
inline constexpr const char* kPlanningName = "planning.mrk.json";

/// The markups of a run, in LPS, mm (schema 1.0.3 of 3D Slicer): the plane of the face before and after reaming, the
/// axis of the reamer, entry and deepest point, pegs, landmarks and rim, as far as the run has them. `deepest`: the
/// pose of the tool at the greatest depth, in B.
std::string planning_markups(const SimulationInput& scene, const BoneMetrics& metrics, const ToolPose& deepest);

}  // namespace reamsim
