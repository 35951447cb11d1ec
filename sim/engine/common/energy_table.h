#pragma once

#include <array>

#include "sim/scenario/scenario.h"

namespace reamsim {

/// Density (g/cm³) and cutting energy (mJ) of a whole voxel, by grade: u₀·(ρ/ρ_ref)^p, or interpolated in the
/// scenario's table, constant beyond its ends. Without the size effect.
struct EnergyTable {
  std::array<double, 256> energy_mj{};
  std::array<double, 256> density_g_cm3{};
};

EnergyTable make_energy_table(const CuttingSettings& cutting, double voxel_mm);

}  // namespace reamsim
