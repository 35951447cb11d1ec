// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Core>
#include <span>

namespace reamsim {

/// A colour map: sRGB colours 0…1 at equal steps from 0 to 1, interpolated linearly.
struct ColorMap {
  std::span<const Eigen::Vector3f> stops;

  [[nodiscard]] Eigen::Vector3f at(double x) const;
};

/// Depth: viridis (van der Walt and Smith 2015, matplotlib, CC0) at eleven points, safe for colour-blind readers.
ColorMap depth_colors();

/// Density: red-brown over tan to ivory, like cut bone, ever lighter, fastest for trabecular bone; none a depth colour.
ColorMap density_colors();

}  // namespace reamsim
