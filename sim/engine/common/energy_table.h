#pragma once

#include <array>

#include "sim/scenario/scenario.h"

namespace reamsim {

/// Density (g/cm³) and cutting energy (mJ) of a whole voxel, by grade: u₀·(ρ/ρ_ref)^p, or from the scenario's table
/// where it has one; beyond that table's ends as at its ends. The size effect is not in it.
struct EnergyTable {
  std::array<double, 256> energy_mj{};
  std::array<double, 256> density_g_cm3{};
};

EnergyTable make_energy_table(const CuttingSettings& cutting, double voxel_mm);

}  // namespace reamsim
