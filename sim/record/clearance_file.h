// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "sim/scene/clearance.h"

namespace reamsim {

/// The object `clearance` of summary.json.
nlohmann::ordered_json clearance_json(const HolderClearance& clearance, const SimulationInput& scene);

/// Writes clearance.csv. Throws RunError when the disk is full.
void write_clearance(const std::string& path, const HolderClearance& clearance, double frame_s);

}  // namespace reamsim
