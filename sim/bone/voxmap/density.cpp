// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/voxmap/density.h"

#include <fmt/core.h>

namespace reamsim {

namespace {

/// Cortical bone reaches 2000 HU, enamel 3000. Scanners with 12 bits end at 3071, where metal then is.
constexpr double kMetal_hu = 3000;
/// Less bone than this changes no force noticeably: noise, and the densest spots of a cortex.
constexpr double kLeast_mm3 = 1;
/// The same, as a fraction of the bone.
constexpr double kLeastFraction = 1e-3;

}  // namespace

void DensityLimit::add(double hu, double mm3) {
  bone_mm3_ += mm3;
  if (hu > limit_hu_) denser_mm3_ += mm3;
  if (hu > kMetal_hu) metal_mm3_ += mm3;
}

void DensityLimit::warn(const std::string& path, Diagnostics& report) const {
  const bool metal = metal_mm3_ >= kLeast_mm3;
  if (!metal && (denser_mm3_ < kLeast_mm3 || denser_mm3_ < kLeastFraction * bone_mm3_)) return;
  std::string text = path + ": ";
  if (denser_mm3_ > 0) {
    text += fmt::format(
        "{:.0f} mm3 of the bone is denser than {:g} g/cm3 ({:.0f} HU), the most that is represented; forces there are "
        "too small",
        denser_mm3_, DensityMapping::kMaxDensity_g_cm3, limit_hu_);
  }
  if (metal) {
    text += fmt::format("{}{:.0f} mm3 is above {:.0f} HU: is it metal? crop or cut it", denser_mm3_ > 0 ? "; " : "",
                        metal_mm3_, kMetal_hu);
  }
  report.warn(text);
}

void warn_of_density_limit(const DensityMapping& mapping, const std::string& key, double hu, Diagnostics& report) {
  const double limit_hu = mapping.limit_hu();
  if (hu <= limit_hu) return;
  report.warn(
      fmt::format("{} is {:g} HU, denser than {:g} g/cm3 ({:.0f} HU), the most that is represented; forces there are "
                  "those of {:g} g/cm3",
                  key, hu, DensityMapping::kMaxDensity_g_cm3, limit_hu, DensityMapping::kMaxDensity_g_cm3));
}

}  // namespace reamsim
