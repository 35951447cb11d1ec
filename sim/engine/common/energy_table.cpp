// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/energy_table.h"

#include <algorithm>
#include <cmath>

#include "sim/bone/voxmap/density.h"

namespace reamsim {

namespace {

double interpolated(const std::vector<SpecificEnergySettings>& table, double density_g_cm3) {
  const auto above = std::ranges::upper_bound(table, density_g_cm3, {}, &SpecificEnergySettings::density_g_cm3);
  if (above == table.begin()) return table.front().energy_j_mm3;
  if (above == table.end()) return table.back().energy_j_mm3;
  const SpecificEnergySettings& below = *(above - 1);
  const double t = (density_g_cm3 - below.density_g_cm3) / (above->density_g_cm3 - below.density_g_cm3);
  return below.energy_j_mm3 + t * (above->energy_j_mm3 - below.energy_j_mm3);
}

}  // namespace

double cutting_energy_mj(const CuttingSettings& cutting, double density_g_cm3, double voxel_mm) {
  constexpr double kMillijoulePerJoule = 1000;
  if (!cutting.specific_energy_table.empty()) {
    return kMillijoulePerJoule * interpolated(cutting.specific_energy_table, density_g_cm3) * voxel_mm * voxel_mm *
           voxel_mm;
  }
  const double whole = kMillijoulePerJoule * cutting.specific_energy_j_mm3 * voxel_mm * voxel_mm * voxel_mm;
  return whole * std::pow(density_g_cm3 / cutting.reference_density_g_cm3, cutting.density_exponent);
}

EnergyTable make_energy_table(const CuttingSettings& cutting, double voxel_mm) {
  EnergyTable table;
  for (std::size_t grade = 1; grade < table.energy_mj.size(); ++grade) {
    const double density = DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade));
    table.density_g_cm3[grade] = density;
    table.energy_mj[grade] = cutting_energy_mj(cutting, density, voxel_mm);
  }
  return table;
}

}  // namespace reamsim
