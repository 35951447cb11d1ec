// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <vector>

#include "sim/engine/common/substep.h"
#include "sim/record/results.h"

namespace reamsim {

/// A frame with substeps in the engine's batch.
struct PendingFrame {
  std::int64_t frame = 0;
  int pass = 1;
  ToolPose before;  ///< pose at the start of the frame
  ToolPose pose;    ///< pose at its end
  int substeps = 1;
  double time_s = 0;  ///< at its end
  std::optional<PushResult> push = {};
  std::optional<Vec3> deflection_mm = {};
  std::vector<std::pair<std::size_t, Substep>>
      cut;  ///< (index in the batch, substep) of those that passed the broad phase
  double broad_phase_s = 0;
};

/// The energy balance of a run so far, and where it began to cut.
struct EnergySums {
  double work_mj = 0;
  double floor_mj = 0;
  double cut_mj = 0;
  std::optional<Vec3> first_contact_mm = {};  ///< of the tool's origin, B
};

/// Converts the integer sums of the substeps to the rows of forces.csv, and keeps the energy balance: the work on the
/// bone, −Σ(T·ω + F·v)·Δt + E_floor, against the cutting energy, which is summed independently (docs/physics.md, 5).
class EnergyBalance {
 public:
  /// `sums_rotate`: sums are in the shell's frame, which rotates with resolved cutting edges (law per_point), and not
  /// in the tool's frame without spin.
  /// `contact_mm`: the tool's origin at the first contact (B), where that has been found before the run.
  EnergyBalance(double voxel_mm3, bool sums_rotate, const std::optional<Vec3>& contact_mm = {})
      : voxel_mm3_(voxel_mm3), sums_rotate_(sums_rotate), contact_mm_(contact_mm) {}

  FrameResult close(const PendingFrame& frame, const std::vector<SubstepSums>& sums);

  /// (work + E_floor − cut)/cut; 0 before contact.
  [[nodiscard]] double balance() const {
    return run_.cut_mj > 0 ? (run_.work_mj + run_.floor_mj - run_.cut_mj) / run_.cut_mj : 0;
  }
  [[nodiscard]] const EnergySums& sums() const { return run_; }
  /// The next frame is the first one of another tool.
  void begin_pass() { run_.first_contact_mm.reset(); }
  /// Continues a run.
  void restore(const EnergySums& sums) { run_ = sums; }

 private:
  double voxel_mm3_;
  bool sums_rotate_;
  std::optional<Vec3> contact_mm_;
  EnergySums run_;
};

}  // namespace reamsim
