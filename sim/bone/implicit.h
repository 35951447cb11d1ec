#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim::implicit {

// Solids as functions: negative inside, about the distance to the surface in mm near it.

/// 0 below `from`, 1 above `to`, smooth between; falls instead when `from` > `to`.
inline double smoothstep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// Union of two solids whose seam is filled with a fillet about `blend_mm` wide.
inline double smooth_union(double a, double b, double blend_mm) {
  const double h = std::max(blend_mm - std::abs(a - b), 0.0) / blend_mm;
  return std::min(a, b) - 0.25 * h * h * blend_mm;
}

/// Intersection of two solids with a rounded edge.
inline double smooth_intersection(double a, double b, double blend_mm) {
  return -smooth_union(-a, -b, blend_mm);
}

/// Outline of two circles and their outer tangents, exact distance. Circle `low` about (0, low_y), circle `high` about
/// (0, high_y > low_y).
double pear(double x, double y, double low_y, double low_radius, double high_y, double high_radius);

/// A rod from `a` to `b` whose radius goes linearly from `radius_a` to `radius_b`.
double tapered_rod(const Vec3& point, const Vec3& a, double radius_a, const Vec3& b, double radius_b);

/// A simple polygon in the plane, exact signed distance.
double polygon(const Vec2& point, const std::vector<Vec2>& corners);

}  // namespace reamsim::implicit
