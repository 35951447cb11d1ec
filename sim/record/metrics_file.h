// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "sim/anatomy/run_metrics.h"
#include "sim/scene/clearance.h"

namespace reamsim {

/// The object `metrics` of summary.json; missing values are null.
nlohmann::ordered_json metrics_json(const BoneMetrics& metrics);

/// Writes depth_map.csv: a row for each column that meets bone. Throws RunError when it cannot be written.
void write_depth_map(const std::string& path, const ColumnMap& map);

/// The object `clearance` of summary.json.
nlohmann::ordered_json clearance_json(const HolderClearance& clearance, const SimulationInput& scene);

/// Writes clearance.csv. Throws RunError when the disk is full.
void write_clearance(const std::string& path, const HolderClearance& clearance, double frame_s);

}  // namespace reamsim
