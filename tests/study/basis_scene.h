// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>

#include "sim/study/reforce.h"
#include "tests/engine/outcome.h"

namespace reamsim::test {

/// Keeps the rows of a run.
class RowSink final : public FrameSink {
 public:
  void frame(const FrameResult& result, const FrameTimes& /*times*/) override { results.push_back(result); }
  void basis(const std::vector<BasisRow>& rows) override {
    basis_rows.insert(basis_rows.end(), rows.begin(), rows.end());
  }
  void snapshot(std::int64_t /*frame*/, FillBricks& /*fill*/) override {}
  void removed(const RemovedFrames& /*voxels*/) override {}

  std::vector<FrameResult> results;
  std::vector<BasisRow> basis_rows;
};

inline RowSink rows_of(SimulationInput scene, bool basis) {
  scene.scenario.output.force_basis = basis;
  const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  RowSink sink;
  Diagnostics report;
  simulate(scene, *engine, sink, {}, report);
  return sink;
}

/// Largest differences between the forces of a basis and a run, relative to the run's peaks.
struct BasisError {
  double force = 0, torque = 0, energy = 0, floor_energy = 0, work = 0;
};

inline BasisError error_of(const ForceBasis& basis, const CuttingSettings& cutting,
                           const std::vector<FrameResult>& results) {
  const ForceConstants constants = force_constants(cutting);
  BasisError error;
  double force = 0, torque = 0, energy = 0, work = 0, floor = 0, cut = 0, cut_of_run = 0;
  for (const FrameResult& result : results) {
    const FrameForces found = basis.forces(result.frame, constants);
    force = std::max(force, result.force_n.norm());
    torque = std::max(torque, result.torque_nmm.norm());
    energy = std::max(energy, result.energy_mj);
    error.force = std::max(error.force, (found.force_n - result.force_n).norm());
    error.torque = std::max(error.torque, (found.torque_nmm - result.torque_nmm).norm());
    error.energy = std::max(error.energy, std::abs(found.energy_mj - result.energy_mj));
    error.floor_energy = std::max(error.floor_energy, std::abs(found.floor_energy_mj - result.floor_energy_mj));
    work += found.work_mj;
    floor += found.floor_energy_mj;
    cut += found.energy_mj;
    // What does not balance, because the balance itself is a small difference divided by a small number at first.
    cut_of_run += result.energy_mj;
    error.work = std::max(error.work, std::abs(work + floor - cut - result.balance * cut_of_run));
  }
  EXPECT_GT(force, 0);
  error.force /= force;
  error.torque /= torque;
  error.energy /= energy;
  error.floor_energy /= energy;
  error.work /= cut;
  return error;
}

}  // namespace reamsim::test
