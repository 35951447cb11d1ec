#pragma once

#include <optional>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

/// The plane with the least sum of squared distances.
struct PlaneFit {
  Vec3 point_mm = Vec3::Zero();  ///< the points' mean
  Vec3 normal = Vec3::UnitZ();   ///< of length 1
  double rms_mm = 0;             ///< root mean square distance of the points
};

/// The sphere with the least sum of squared distances from its surface.
struct SphereFit {
  Vec3 center_mm = Vec3::Zero();
  double radius_mm = 0;
  double rms_mm = 0;
};

/// Fits a plane; its normal points to the side of `outward`. nullopt for fewer than three points, or points on a line.
std::optional<PlaneFit> fit_plane(const std::vector<Vec3>& points_mm, const Vec3& outward);

/// Fits a sphere: the algebraic fit (linear in centre and R² − |c|²), refined by Gauss–Newton on the distances. nullopt
/// for fewer than four points, or points so flat that the radius would exceed kLargestRadius_mm.
std::optional<SphereFit> fit_sphere(const std::vector<Vec3>& points_mm);

inline constexpr double kLargestRadius_mm = 1000;

}  // namespace reamsim
