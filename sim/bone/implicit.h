// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim::implicit {

inline double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

inline double distance_to_segment(const Vec2& point, const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((point - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (point - a - t * along).norm();
}

// Solids as functions: negative inside, near the surface about the distance from it in mm.

/// 0 below `from`, 1 above `to`, smooth between; decreasing if `from` > `to`.
inline double smoothstep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// Union of two solids with a fillet of about `blend_mm` in width.
inline double smooth_union(double a, double b, double blend_mm) {
  const double h = std::max(blend_mm - std::abs(a - b), 0.0) / blend_mm;
  return std::min(a, b) - 0.25 * h * h * blend_mm;
}

/// The same with a solid that is at least `least_b` and evaluated only where it matters.
template <class Solid>
double smooth_union(double a, double least_b, double blend_mm, const Solid& b) {
  return least_b - a >= blend_mm ? a : smooth_union(a, b(), blend_mm);
}

/// Intersection of two solids with a rounded edge.
inline double smooth_intersection(double a, double b, double blend_mm) {
  return -smooth_union(-a, -b, blend_mm);
}

/// Exact distance from two circles about (0, low_y) and (0, high_y > low_y) and their outer tangents.
inline double pear(double x, double y, double low_y, double low_radius, double high_y, double high_radius) {
  const double across = std::abs(x);
  const double up = y - low_y;
  const double height = high_y - low_y;
  const double sine = (low_radius - high_radius) / height;  // of the angle between the tangents and the axis
  const double cosine = std::sqrt(std::max(1 - sine * sine, 0.0));
  const double along = cosine * up - sine * across;
  if (along < 0) return std::hypot(across, up) - low_radius;
  if (along > cosine * height) return std::hypot(across, up - height) - high_radius;
  return cosine * across + sine * up - low_radius;
}

/// A simple polygon in the plane, exact signed distance.
inline double polygon(const Vec2& point, const std::vector<Vec2>& corners) {
  double nearest2 = (point - corners[0]).squaredNorm();
  bool inside = false;
  for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
    const Vec2 edge = corners[j] - corners[i];
    const Vec2 from = point - corners[i];
    const double fraction = std::clamp(from.dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest2 = std::min(nearest2, (from - fraction * edge).squaredNorm());
    const bool crosses = (corners[i].y() > point.y()) != (corners[j].y() > point.y());
    if (crosses && from.x() < edge.x() * from.y() / edge.y()) inside = !inside;
  }
  return (inside ? -1 : 1) * std::sqrt(nearest2);
}

/// The last arguments inside and outside after `steps` halvings of the interval between them.
struct Bracket {
  double inside;
  double outside;

  [[nodiscard]] double middle() const { return 0.5 * (inside + outside); }
};
template <class Inside>
Bracket bisect(double inside, double outside, int steps, const Inside& is_inside) {
  for (int i = 0; i < steps; ++i) {
    const double middle = (inside + outside) / 2;
    (is_inside(middle) ? inside : outside) = middle;
  }
  return {inside, outside};
}

}  // namespace reamsim::implicit
