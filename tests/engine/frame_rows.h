// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <vector>

#include "sim/run/simulation.h"

namespace reamsim::test {

/// Collects the rows of a run and the frames of its pictures, and can be continued.
class FrameRows final : public FrameSink {
 public:
  std::vector<FrameResult> rows;
  std::vector<std::int64_t> pictures;

  void frame(const FrameResult& result, const FrameTimes&) override { rows.push_back(result); }
  void snapshot(std::int64_t frame, FillBricks&) override { pictures.push_back(frame); }
  void removed(const RemovedFrames&) override {}
};

/// Runs a scene on the engine of its scenario.
inline FrameRows run_rows(SimulationInput scene) {
  const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  FrameRows sink;
  Diagnostics report;
  simulate(scene, *engine, sink, {}, report);
  return sink;
}

}  // namespace reamsim::test
