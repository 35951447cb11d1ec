// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/verify/reaming.h"

#include <cmath>
#include <utility>

namespace reamsim::verify {

namespace {

/// Collects the rows.
class Rows final : public FrameSink {
 public:
  std::vector<FrameResult> rows;

  void frame(const FrameResult& result, const FrameTimes& /*times*/) override { rows.push_back(result); }
  void snapshot(std::int64_t /*frame*/, FillBricks& /*fill*/) override {}
  void removed(const RemovedFrames& /*voxels*/) override {}
};

}  // namespace

double Reamed::removed_mm3() const {
  double sum = 0;
  for (const FrameResult& row : rows) sum += row.removed_mm3;
  return sum;
}

Reamed ream(SimulationInput scene, const Setting& setting) {
  scene.scenario.engine.device = setting.device;
  const auto engine = setting.engine(scene.scenario, scene.bone, scene.tool);
  Rows sink;
  Diagnostics report;
  RunControl control;
  control.stop = setting.stop;
  const SimulationState end = simulate(scene, *engine, sink, control, report);
  return {std::move(sink.rows), std::move(scene.bone), end.feed, end.springs};
}

MeanLoads mean_loads(std::span<const FrameResult> rows) {
  MeanLoads out;
  for (const FrameResult& row : rows) {
    out.force_n += row.force_n;
    out.torque_nmm += row.torque_nmm;
    out.axial_force_n += row.axial_force_n;
    out.spin_torque_nmm += row.spin_torque_nmm;
    out.removed_mm3 += row.removed_mm3;
  }
  const auto n = static_cast<double>(rows.size());
  out.force_n /= n;
  out.torque_nmm /= n;
  out.axial_force_n /= n;
  out.spin_torque_nmm /= n;
  return out;
}

double torque_ripple(std::span<const FrameResult> rows) {
  const double mean = mean_loads(rows).spin_torque_nmm;
  double squares = 0;
  for (const FrameResult& row : rows) squares += (row.spin_torque_nmm - mean) * (row.spin_torque_nmm - mean);
  return std::sqrt(squares / static_cast<double>(rows.size())) / mean;
}

double rms(std::span<const double> values) {
  double squares = 0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

}  // namespace reamsim::verify
