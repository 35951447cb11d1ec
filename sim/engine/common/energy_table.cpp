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

EnergyTable make_energy_table(const CuttingSettings& cutting, double voxel_mm) {
  constexpr double kMillijoulePerJoule = 1000;
  const double whole = kMillijoulePerJoule * cutting.specific_energy_j_mm3 * voxel_mm * voxel_mm * voxel_mm;
  const bool power_law = cutting.specific_energy_table.empty();
  EnergyTable table;
  for (std::size_t grade = 1; grade < table.energy_mj.size(); ++grade) {
    const double density = DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade));
    table.density_g_cm3[grade] = density;
    table.energy_mj[grade] = power_law
                                 ? whole * std::pow(density / cutting.reference_density_g_cm3, cutting.density_exponent)
                                 : kMillijoulePerJoule * interpolated(cutting.specific_energy_table, density) *
                                       voxel_mm * voxel_mm * voxel_mm;
  }
  return table;
}

}  // namespace reamsim
