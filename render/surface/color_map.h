// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <span>

namespace reamsim {

/// A colour map: sRGB colours 0…1 at equal steps from 0 to 1, interpolated linearly.
struct ColorMap {
  std::span<const Eigen::Vector3f> stops;

  [[nodiscard]] Eigen::Vector3f at(double x) const {
    const double position = std::clamp(x, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
    const auto lower = std::min(static_cast<std::size_t>(position), stops.size() - 2);
    const auto fraction = static_cast<float>(position - static_cast<double>(lower));
    return (1 - fraction) * stops[lower] + fraction * stops[lower + 1];
  }
};

/// Depth: viridis (van der Walt and Smith 2015, matplotlib, CC0) at eleven points, safe for colour-blind readers.
inline ColorMap depth_colors() {
  using Color = Eigen::Vector3f;
  static const std::array<Color, 11> kViridis{
      Color{0.267F, 0.005F, 0.329F}, Color{0.283F, 0.141F, 0.458F}, Color{0.254F, 0.265F, 0.530F},
      Color{0.207F, 0.372F, 0.553F}, Color{0.164F, 0.471F, 0.558F}, Color{0.128F, 0.567F, 0.551F},
      Color{0.135F, 0.659F, 0.518F}, Color{0.267F, 0.749F, 0.441F}, Color{0.478F, 0.821F, 0.318F},
      Color{0.741F, 0.873F, 0.150F}, Color{0.993F, 0.906F, 0.144F}};
  return {kViridis};
}

/// Density: red-brown over tan to ivory, like cut bone, ever lighter, fastest for trabecular bone; none a depth colour.
inline ColorMap density_colors() {
  using Color = Eigen::Vector3f;
  static const std::array<Color, 9> kCutBone{
      Color{0.16F, 0.04F, 0.05F}, Color{0.36F, 0.11F, 0.09F}, Color{0.52F, 0.22F, 0.15F},
      Color{0.65F, 0.34F, 0.22F}, Color{0.75F, 0.47F, 0.31F}, Color{0.83F, 0.60F, 0.42F},
      Color{0.89F, 0.73F, 0.56F}, Color{0.95F, 0.86F, 0.73F}, Color{1.00F, 0.98F, 0.92F}};
  return {kCutBone};
}

}  // namespace reamsim
