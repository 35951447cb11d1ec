// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>

#include "sim/scenario/scenario.h"

namespace reamsim {

/// Energy to cut a whole voxel of bone of that density, mJ: u₀·(ρ/ρ_ref)^p, or interpolated in the scenario's table,
/// constant beyond its ends. Without the size effect.
double cutting_energy_mj(const CuttingSettings& cutting, double density_g_cm3, double voxel_mm);

/// Density (g/cm³) and cutting energy (mJ) of a whole voxel, by grade.
struct EnergyTable {
  std::array<double, 256> energy_mj{};
  std::array<double, 256> density_g_cm3{};
};

EnergyTable make_energy_table(const CuttingSettings& cutting, double voxel_mm);

}  // namespace reamsim
