#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

namespace reamsim {

/// A colour map: sRGB colours 0…1 at equal steps from 0 to 1, linear between them.
struct ColorMap {
  std::span<const Eigen::Vector3f> stops;

  [[nodiscard]] Eigen::Vector3f at(double x) const;
  /// The stops as numbers, for a texture.
  [[nodiscard]] std::vector<float> texels() const;
};

/// Depth: viridis (van der Walt and Smith 2015, matplotlib, released as CC0), taken at eleven points. Perceptually
/// uniform, and readable with any colour vision.
ColorMap depth_colors();

/// Density: from the dark red-brown of marrow over tan to ivory, as a cut bone looks. Lightness rises all the way, a
/// little faster where trabecular bone lies; it shares no colour with the depths.
ColorMap density_colors();

}  // namespace reamsim
