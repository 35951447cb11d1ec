// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/boundary_layers.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "sim/base/gaussian.h"

namespace reamsim::ct {

namespace {

constexpr double kSigma = 1.2;  // of the Gaussian, in the longest side of a voxel
constexpr double kReach = 3;    // standard deviations
constexpr double kUniform = 1e-4;

/// A Gaussian along one axis. Beyond the image the value of the border holds.
void smooth_along(AlignedImage& image, int axis, double sigma_voxels) {
  const Lattice& lattice = image.lattice;
  const int reach = static_cast<int>(std::ceil(kReach * sigma_voxels));
  const std::vector<double> weights = gaussian(sigma_voxels, reach);
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  const std::size_t stride = lattice.index(Vec3i::Unit(axis));
  const int length = lattice.dims[axis];
  std::vector<double> line(static_cast<std::size_t>(length));
  for (std::size_t start = 0; start < image.value.size(); ++start) {
    if (lattice.voxel_at(start)[axis] != 0) continue;
    for (std::size_t n = 0; n < line.size(); ++n) line[n] = double{image.value[start + stride * n]};
    for (int n = 0; n < length; ++n) {
      double value = 0;
      for (int k = -reach; k <= reach; ++k) {
        value += weights[static_cast<std::size_t>(k + reach)] *
                 line[static_cast<std::size_t>(std::clamp(n + k, 0, length - 1))];
      }
      image.value[start + stride * static_cast<std::size_t>(n)] = static_cast<float>(value / sum);
    }
  }
}

/// The mean of the known voxels among the 26 neighbours, in double precision and a fixed order; nullopt without any.
std::optional<float> mean_of_known(const AlignedImage& image, const Mask& known, const Vec3i& voxel) {
  double sum = 0;
  int count = 0;
  for_each_voxel(voxel - Vec3i::Ones(), voxel + Vec3i::Ones(), [&](const Vec3i& v) {
    if (!image.lattice.contains(v) || known[image.lattice.index(v)] == 0) return;
    sum += double{image.at(v)};
    ++count;
  });
  return count == 0 ? std::nullopt : std::optional(static_cast<float>(sum / count));
}

}  // namespace

BoundaryNormals::BoundaryNormals(const Mask& bone, const Lattice& lattice)
    : smooth_{lattice, std::vector<float>(bone.begin(), bone.end())} {
  const double sigma_mm = kSigma * lattice.spacing_mm.maxCoeff();
  for (int axis = 0; axis < 3; ++axis) smooth_along(smooth_, axis, sigma_mm / lattice.spacing_mm[axis]);
}

Vec3 BoundaryNormals::inward(const Vec3i& voxel) const {
  const Vec3 gradient = smooth_.gradient(voxel);
  const bool uniform = gradient.norm() * smooth_.lattice.spacing_mm.maxCoeff() < kUniform;
  return uniform ? Vec3(Vec3::Zero()) : gradient.normalized();
}

double noise_between(const AlignedImage& image, const Mask& mask) {
  constexpr std::size_t kFewest = 30;
  constexpr double kDeviationOfMedian = 1.4826;  // normal distribution: standard over median absolute deviation
  const Lattice& lattice = image.lattice;
  std::vector<float> differences;
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t stride = lattice.index(Vec3i::Unit(axis));
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
  return kDeviationOfMedian * double{*middle} / std::sqrt(6.0);
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
