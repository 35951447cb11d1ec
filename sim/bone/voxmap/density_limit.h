// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/base/diagnostics.h"
#include "sim/bone/voxmap/density.h"

namespace reamsim {

/// Measures how much bone of a scan is denser than a grade can hold.
class DensityLimit {
 public:
  explicit DensityLimit(const DensityMapping& mapping);

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
