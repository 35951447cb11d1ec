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

constexpr Measured kMeasured[] = {{0.6, 3e-5}, {0.7, 6e-4}, {1.0, 4.4e-2}};

}  // namespace

double expected_leak(double spacing_voxels) {
  if (spacing_voxels <= 0.5) return 0;
  if (spacing_voxels <= kMeasured[0].spacing_voxels) return kMeasured[0].leak;
  for (std::size_t i = 1; i < std::size(kMeasured); ++i) {
    const Measured &a = kMeasured[i - 1], &b = kMeasured[i];
    if (spacing_voxels > b.spacing_voxels) continue;
    const double share = (spacing_voxels - a.spacing_voxels) / (b.spacing_voxels - a.spacing_voxels);
    return a.leak * std::pow(b.leak / a.leak, share);
  }
  return kMeasured[std::size(kMeasured) - 1].leak;
}

}  // namespace reamsim
