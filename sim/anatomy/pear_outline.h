// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

/// The outline of an articular face in its plane: two circles and their outer tangents, a pear (Huysmans et al. 2006,
/// Journal of Shoulder and Elbow Surgery 15, 759–763: the inferior part of the glenoid is a circle).
struct PearOutline {
  Vec2 center_mm = Vec2::Zero();  ///< the middle of the height, on the long axis
  double axis_rad = 0;            ///< direction from the larger circle to the smaller, from +x of the plane
  double height_mm = 0;           ///< along that direction
  double radius_mm = 0;           ///< of the larger circle; half of the width
  double upper_ratio = 0;         ///< radius of the smaller circle over that of the larger, 0.5…0.95

  /// Distance of a point from the outline, negative inside, mm.
  [[nodiscard]] double distance_mm(const Vec2& point_mm) const;
  [[nodiscard]] Vec2 axis() const { return {std::cos(axis_rad), std::sin(axis_rad)}; }
};

/// An outline fitted robustly to points of a rim.
struct OutlineFit {
  PearOutline outline;
  double inlier_fraction = 0;  ///< points within kRimInlier_mm
  double rms_mm = 0;           ///< of these
};

inline constexpr double kRimInlier_mm = 1.5;

/// Least squares with Tukey's weights, by Levenberg and Marquardt; parts of the rim that are worn away do not count.
/// nullopt for fewer than 12 points.
std::optional<OutlineFit> fit_pear(const std::vector<Vec2>& rim_mm);

}  // namespace reamsim
