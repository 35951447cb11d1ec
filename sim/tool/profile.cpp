// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/profile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace reamsim {

namespace {

struct EdgeDistance {
  double squared_mm2;
  double side_mm;  ///< signed distance from the edge's line, positive outside
  Vec2 from_surface;
  Vec2 normal;
};

EdgeDistance distance_to_edge(const Vec2& point, const Vec2& a, const Vec2& b) {
  const Vec2 edge = b - a;
  const double t = (point - a).dot(edge) / edge.squaredNorm();
  // At its ends the very vertex, not a rounded one: edges that share it must tie.
  const Vec2 offset = point - (t <= 0 ? a : t >= 1 ? b : Vec2(a + t * edge));
  const Vec2 normal = Vec2(edge.y(), -edge.x()).normalized();
  return {offset.squaredNorm(), offset.dot(normal), offset, normal};
}

}  // namespace

double Profile::max_radius_mm() const {
  double radius = 0;
  for (const Vec2& p : points) radius = std::max(radius, p.x());
  return radius;
}

Aabb Profile::bounds() const {
  const double radius = max_radius_mm();
  Aabb box{{-radius, -radius, std::numeric_limits<double>::infinity()},
           {radius, radius, -std::numeric_limits<double>::infinity()}};
  for (const Vec2& p : points) {
    box.min.z() = std::min(box.min.z(), p.y());
    box.max.z() = std::max(box.max.z(), p.y());
  }
  return box;
}

Profile::Nearest Profile::nearest(const Vec2& rz) const {
  EdgeDistance best{std::numeric_limits<double>::infinity(), 0, Vec2::Zero(), -Vec2::UnitY()};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2& a = points[i];
    const Vec2& b = points[(i + 1) % points.size()];
    if (on_axis(a) && on_axis(b)) continue;
    if (a == b) continue;
    const EdgeDistance d = distance_to_edge(rz, a, b);
    // Two edges that share the nearest vertex tie; the more perpendicular one decides the sign.
    const bool tie = d.squared_mm2 == best.squared_mm2 && std::abs(d.side_mm) > std::abs(best.side_mm);
    if (d.squared_mm2 < best.squared_mm2 || tie) best = d;
  }
  const double distance = std::sqrt(best.squared_mm2);
  const double sign = best.side_mm < 0 ? -1.0 : 1.0;
  if (distance < kOnSurfaceMm) return {sign * distance, best.normal};
  return {sign * distance, sign * best.from_surface / distance};
}

double Profile::volume_mm3() const {
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2& a = points[i];
    const Vec2& b = points[(i + 1) % points.size()];
    sum += (b.y() - a.y()) * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x());
  }
  return std::numbers::pi / 3 * sum;
}

}  // namespace reamsim
