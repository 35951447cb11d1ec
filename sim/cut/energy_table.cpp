#include "sim/cut/energy_table.h"

#include <cmath>

#include "sim/bone/density.h"

namespace reamsim {

EnergyTable make_energy_table(const CuttingSettings& cutting, double voxel_mm) {
  constexpr double kMillijoulePerJoule = 1000;
  const double whole = kMillijoulePerJoule * cutting.specific_energy_j_mm3 * voxel_mm * voxel_mm * voxel_mm;
  EnergyTable table;
  for (std::size_t grade = 1; grade < table.energy_mj.size(); ++grade) {
    const double density = DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade));
    table.density_g_cm3[grade] = density;
    table.energy_mj[grade] = whole * std::pow(density / cutting.reference_density_g_cm3, cutting.density_exponent);
  }
  return table;
}

}  // namespace reamsim
