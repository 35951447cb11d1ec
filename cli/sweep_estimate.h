// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "sim/run/run_scenario.h"
#include "sim/scene/scene.h"

namespace reamsim {

/// What a run would take.
struct RunEstimate {
  double load_s = 0;
  double simulate_s = 0;
  std::size_t memory_bytes = 0;  ///< of the process, without pictures
  std::int64_t frames = 0;
  std::vector<std::string> warnings;

  /// On one line, and back. Throws RunError where the line is none.
  [[nodiscard]] std::string text() const;
  static RunEstimate parse(const std::string& text);
};

/// Validates runs as `reamsim check` does, and estimates their cost. Of runs with the same bone, tool and force basis,
/// only the first is timed.
class RunEstimator {
 public:
  /// `resources` must have a cache of bones. Throws InputError with every mistake of the scenario.
  RunEstimate estimate(const Scenario& scenario, RunResources& resources);

 private:
  double simulate_s(SimulationInput& scene, RunResources& resources);

  /// By bone (BoneCache::loaded), tool, and whether a force basis is written, which takes longer than the frames.
  std::map<std::tuple<int, std::string, bool>, double> s_per_frame_;
};

}  // namespace reamsim
