#pragma once

#include <cstdint>

#include "sim/bone/voxmap/density.h"

namespace reamsim {

/// Grades as float HU, the way that Zheng et al. keep voxels. HU is linear in density, and so in the grade; the grade
/// comes back from its HU without loss as long as a grade's step is well above the float's rounding.
struct HuScale {
  double of_air;     ///< HU of density 0, which stands for air; bone lies above it
  double per_grade;  ///< HU from one grade to the next

  explicit HuScale(const DensityMapping& mapping)
      : of_air(mapping.hu_from_density(0)),
        per_grade(mapping.hu_from_density(DensityMapping::kGradeStep_g_cm3) - of_air) {}

  [[nodiscard]] float hu(std::uint8_t grade) const { return static_cast<float>(of_air + grade * per_grade); }
  /// As cut_voxels.cl finds it.
  [[nodiscard]] int grade(float hu) const { return static_cast<int>(std::floor((hu - of_air) / per_grade + 0.5)); }

  /// Whether every grade survives the float.
  [[nodiscard]] bool exact() const {
    for (int g = 0; g <= 255; ++g) {
      const auto value = static_cast<std::uint8_t>(g);
      if (grade(hu(value)) != g || (g > 0) != (hu(value) > static_cast<float>(of_air))) return false;
    }
    return true;
  }
};

}  // namespace reamsim
