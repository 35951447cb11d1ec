// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>

#include "sim/scene/scene.h"

namespace reamsim {

/// Called with a pass and the fill of the bone before it.
using VisitPass = std::function<void(const FillBricks& fill, const Tool& tool, const Motion& motion)>;

/// Visits the present pass and the later ones, with the bone that the passes before are predicted to leave
/// (swept_bone.h).
void for_each_predicted_pass(const SimulationInput& scene, const VisitPass& visit);

}  // namespace reamsim
