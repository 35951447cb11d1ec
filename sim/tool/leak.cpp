// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/leak.h"

#include <cmath>
#include <cstddef>
#include <iterator>

namespace reamsim {

namespace {

struct Measured {
  double spacing_voxels;
  double leak;
};

/// Means over random orientations and offsets of the cube: 4·10⁶ up to 0.8, 4·10⁵ above.
constexpr Measured kMeasured[] = {{kHardlyLeakingSpacing, 1e-6},
                                  {0.75, 4.7e-5},
                                  {0.8, 8.0e-4},
                                  {0.85, 3.8e-3},
                                  {0.9, 1.05e-2},
                                  {1.0, 4.2e-2},
                                  {1.2, 0.196},
                                  {1.5, 0.466},
                                  {2.0, 0.700},
                                  {kLargestMeasuredSpacing, 0.866}};

}  // namespace

double expected_leak(double spacing_voxels) {
  if (spacing_voxels <= 0.5) return 0;
  if (spacing_voxels <= kMeasured[0].spacing_voxels) return kMeasured[0].leak;
  for (std::size_t i = 1; i < std::size(kMeasured); ++i) {
    const Measured &a = kMeasured[i - 1], &b = kMeasured[i];
    if (spacing_voxels > b.spacing_voxels) continue;
    const double t = (spacing_voxels - a.spacing_voxels) / (b.spacing_voxels - a.spacing_voxels);
    return a.leak * std::pow(b.leak / a.leak, t);
  }
  return kMeasured[std::size(kMeasured) - 1].leak;
}

}  // namespace reamsim
