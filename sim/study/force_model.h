// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/bone/voxmap/density.h"
#include "sim/record/results.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The constants in which forces are linear, or products of two (docs/physics.md, 4).
struct ForceConstants {
  std::array<double, 256> specific_energy_n_mm2{};  ///< u by grade, N/mm² = mJ/mm³
  double normal_ratio = 0;                          ///< k_n
  double edge_tangential_n_mm = 0;                  ///< K_t
  double edge_normal_n_mm = 0;                      ///< K_n
};

/// Another relation from HU to density than that of the run.
struct Recalibration {
  DensityMapping of_run;
  DensityMapping now;

  /// The density that a voxel of that grade has now, g/cm³.
  [[nodiscard]] double density(int grade) const;
};

ForceConstants force_constants(const CuttingSettings& cutting,
                               const std::optional<Recalibration>& recalibration = std::nullopt);

/// Force and torque of the bone on the tool (B), and energies of a frame.
struct FrameForces {
  Vec3 force_n = Vec3::Zero();
  Vec3 torque_nmm = Vec3::Zero();
  double energy_mj = 0;
  double floor_energy_mj = 0;
  double work_mj = 0;  ///< on the bone
};

/// The force basis of a run.
class ForceBasis {
 public:
  /// `rows`: in ascending frames.
  explicit ForceBasis(std::vector<BasisRow> rows) : rows_(std::move(rows)) {}

  [[nodiscard]] const std::vector<BasisRow>& rows() const { return rows_; }
  /// Those of a frame; none without contact.
  [[nodiscard]] std::span<const BasisRow> of(std::int64_t frame) const;
  /// The forces of a frame.
  [[nodiscard]] FrameForces forces(std::int64_t frame, const ForceConstants& constants) const;
  /// Removed volume by grade over all frames, mm³; with a size effect, weighted by its factor.
  [[nodiscard]] std::array<double, 256> volume_mm3() const;
  /// Whether it has parts of an edge force.
  [[nodiscard]] bool has_edge() const;

 private:
  std::vector<BasisRow> rows_;
};

}  // namespace reamsim
