#pragma once

#include <array>

#include "sim/scenario/scenario.h"

namespace reamsim {

/// Density (g/cm³) and cutting energy (mJ) of a whole voxel, by grade. u(ρ) = u₀·(ρ/ρ_ref)^p (design §5).
struct EnergyTable {
  std::array<double, 256> energy_mj{};
  std::array<double, 256> density_g_cm3{};
};

EnergyTable make_energy_table(const CuttingSettings& cutting, double voxel_mm);

}  // namespace reamsim
