// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

namespace reamsim {

/// The arithmetic mean; 0 of no values.
inline double mean(const std::vector<double>& values) {
  if (values.empty()) return 0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// The value below which a fraction (0…1) of the values lies, interpolated linearly (type 7 of Hyndman and Fan 1996,
/// The American Statistician 50, 361–365; numpy's default); 0 of no values.
inline double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  const double place = fraction * static_cast<double>(values.size() - 1);
  const auto below = values.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(values.begin(), below, values.end());
  const double above = below + 1 == values.end() ? *below : *std::min_element(below + 1, values.end());
  return *below + (place - std::floor(place)) * (above - *below);
}

/// A Gaussian sampled at −reach … reach, with the maximum 1.
inline std::vector<double> gaussian(double sigma, int reach) {
  std::vector<double> out;
  for (int n = -reach; n <= reach; ++n) out.push_back(std::exp(-0.5 * n * n / (sigma * sigma)));
  return out;
}

/// The same, scaled to the sum 1.
inline std::vector<double> gaussian_weights(double sigma, int reach) {
  std::vector<double> out = gaussian(sigma, reach);
  const double sum = std::accumulate(out.begin(), out.end(), 0.0);
  for (double& weight : out) weight /= sum;
  return out;
}

}  // namespace reamsim
