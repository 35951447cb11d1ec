#include "sim/bone/ct/boundary_layers.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace reamsim::ct {

namespace {

/// Gives every voxel the least (or the greatest) value within `radius` along one axis.
Mask extreme_along(const Mask& mask, const Lattice& lattice, int axis, int radius, bool greatest) {
  const int length = lattice.dims[axis];
  const auto stride = static_cast<std::size_t>(axis == 0   ? 1
                                               : axis == 1 ? lattice.index({0, 1, 0})
                                                           : lattice.index({0, 0, 1}));
  Mask out(mask.size());
  for (std::size_t at = 0; at < mask.size(); ++at) {
    const int here = static_cast<int>(at / stride % static_cast<std::size_t>(length));
    const int from = std::max(here - radius, 0), to = std::min(here + radius, length - 1);
    std::uint8_t value = greatest ? 0 : 1;
    for (int n = from; n <= to; ++n) {
      const std::uint8_t other =
          mask[at + stride * static_cast<std::size_t>(n) - stride * static_cast<std::size_t>(here)];
      value = greatest ? std::max(value, other) : std::min(value, other);
    }
    out[at] = value;
  }
  return out;
}

Mask extreme_in_box(Mask mask, const Lattice& lattice, const Vec3i& radius, bool greatest) {
  for (int axis = 0; axis < 3; ++axis) mask = extreme_along(mask, lattice, axis, radius[axis], greatest);
  return mask;
}

/// The mean over the known voxels among the 26 round one, in double precision and a fixed order; none: nullopt.
std::optional<float> mean_of_known(const AlignedImage& image, const Mask& known, const Vec3i& voxel) {
  double sum = 0;
  int count = 0;
  for (int n = 0; n < 27; ++n) {
    const Vec3i v = voxel + Vec3i(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
    if (!image.lattice.contains(v)) continue;
    const std::size_t at = image.lattice.index(v);
    if (known[at] == 0) continue;
    sum += double{image.value[at]};
    ++count;
  }
  if (count == 0) return std::nullopt;
  return static_cast<float>(sum / count);
}

}  // namespace

Mask eroded(const Mask& mask, const Lattice& lattice, const Vec3i& radius) {
  return extreme_in_box(mask, lattice, radius, false);
}

Mask dilated(const Mask& mask, const Lattice& lattice, const Vec3i& radius) {
  return extreme_in_box(mask, lattice, radius, true);
}

double noise_between(const AlignedImage& image, const Mask& mask) {
  constexpr std::size_t kFewest = 30;
  const double deviation_of_median = 1.4826;  // of a normal distribution, over the median of its absolute value
  const Lattice& lattice = image.lattice;
  std::vector<float> differences;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3i step = Vec3i::Unit(axis);
    const std::size_t stride = lattice.index(step);
    for (std::size_t at = 0; at < mask.size(); ++at) {
      const int here = lattice.voxel_at(at)[axis];
      if (mask[at] == 0 || here == 0 || here + 1 == lattice.dims[axis]) continue;
      if (mask[at - stride] == 0 || mask[at + stride] == 0) continue;
      differences.push_back(std::abs(image.value[at - stride] - 2 * image.value[at] + image.value[at + stride]));
    }
  }
  if (differences.size() < kFewest) return 0;
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return deviation_of_median * double{*middle} / std::sqrt(6.0);
}

void spread_outwards(AlignedImage& image, Mask& known, int layers) {
  const Lattice& lattice = image.lattice;
  for (int layer = 0; layer < layers; ++layer) {
    std::vector<std::pair<std::size_t, float>> found;
    const Mask wider = dilated(known, lattice, Vec3i::Ones());
    for (std::size_t at = 0; at < known.size(); ++at) {
      if (known[at] != 0 || wider[at] == 0) continue;
      if (const auto mean = mean_of_known(image, known, lattice.voxel_at(at))) found.emplace_back(at, *mean);
    }
    for (const auto& [at, value] : found) {
      image.value[at] = value;
      known[at] = 1;
    }
  }
}

}  // namespace reamsim::ct
