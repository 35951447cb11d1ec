// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "sim/base/error.h"

namespace reamsim {

/// Radiodensity to apparent density to grade (docs/density.md, 1). The defaults are of a femur at 120 kVp (PMC5234499,
/// Table 1), not a scapular calibration.
struct DensityMapping {
  double ash_slope_g_cm3_per_hu = 0.0007;
  double ash_offset_g_cm3 = -0.009;
  double ash_fraction = 0.6;

  static constexpr double kGradeStep_g_cm3 = 0.008;
  static constexpr double kMaxDensity_g_cm3 = 2.0;
  static constexpr int kMaxGrade = 250;

  [[nodiscard]] double density_from_hu(double hu) const {
    const double density = (ash_slope_g_cm3_per_hu * hu + ash_offset_g_cm3) / ash_fraction;
    return std::clamp(density, 0.0, kMaxDensity_g_cm3);
  }
  [[nodiscard]] double hu_from_density(double density_g_cm3) const {
    return (density_g_cm3 * ash_fraction - ash_offset_g_cm3) / ash_slope_g_cm3_per_hu;
  }
  /// The radiodensity of the densest bone that a grade holds.
  [[nodiscard]] double limit_hu() const { return hu_from_density(kMaxDensity_g_cm3); }
  [[nodiscard]] static std::uint8_t grade_from_density(double density_g_cm3) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(density_g_cm3 / kGradeStep_g_cm3), 1L, long{kMaxGrade}));
  }
  [[nodiscard]] static double density_from_grade(std::uint8_t grade) { return grade * kGradeStep_g_cm3; }
};

/// Measures how much bone of a scan is denser than a grade can hold.
class DensityLimit {
 public:
  explicit DensityLimit(const DensityMapping& mapping) : limit_hu_(mapping.limit_hu()) {}

  /// Adds the bone of a voxel.
  void add(double hu, double mm3);
  /// Warns where more bone than noise explains is denser, and asks about metal where its radiodensity suggests it.
  void warn(const std::string& path, Diagnostics& report) const;

 private:
  double limit_hu_;
  double bone_mm3_ = 0;
  double denser_mm3_ = 0;
  double metal_mm3_ = 0;
};

/// Warns if the radiodensity `hu` of a scenario, given by `key`, is denser than a grade can hold.
void warn_of_density_limit(const DensityMapping& mapping, const std::string& key, double hu, Diagnostics& report);

}  // namespace reamsim
