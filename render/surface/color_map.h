// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

namespace reamsim {

/// A colour map: sRGB colours 0…1 at equal steps from 0 to 1, interpolated linearly.
struct ColorMap {
  std::span<const Eigen::Vector3f> stops;

  [[nodiscard]] Eigen::Vector3f at(double x) const;
  /// The stops as texels.
  [[nodiscard]] std::vector<float> texels() const;
};

/// Depth: viridis (van der Walt and Smith 2015, matplotlib, released as CC0), at eleven points: perceptually
/// uniform and safe for colour-blind readers.
ColorMap depth_colors();

/// Density: from the dark red-brown of marrow over tan to ivory, like cut bone. Lightness increases monotonically,
/// faster in the range of trabecular bone. No colour occurs in the depth map.
ColorMap density_colors();

}  // namespace reamsim
