// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <vector>

namespace reamsim {

/// A Gaussian sampled at −reach … reach, with the maximum 1.
inline std::vector<double> gaussian(double sigma, int reach) {
  std::vector<double> out;
  for (int n = -reach; n <= reach; ++n) out.push_back(std::exp(-0.5 * n * n / (sigma * sigma)));
  return out;
}

/// The same, scaled to the sum 1.
inline std::vector<double> gaussian_weights(double sigma, int reach) {
  std::vector<double> out = gaussian(sigma, reach);
  double sum = 0;
  for (const double weight : out) sum += weight;
  for (double& weight : out) weight /= sum;
  return out;
}

}  // namespace reamsim
