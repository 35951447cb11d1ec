// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/polyline.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

namespace reamsim {

namespace {

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double distance_to_segment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

/// Marks the points of points[first…last] to keep, without the ends.
void mark_kept(const std::vector<Vec2>& points, std::size_t first, std::size_t last, double tolerance,
               std::vector<bool>& keep) {
  std::vector<std::pair<std::size_t, std::size_t>> open{{first, last}};
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    double farthest = tolerance;
    std::size_t split = 0;
    for (std::size_t i = a + 1; i < b; ++i) {
      const double d = distance_to_segment(points[i], points[a], points[b]);
      if (d > farthest) {
        farthest = d;
        split = i;
      }
    }
    if (split == 0) continue;
    keep[split] = true;
    open.emplace_back(a, split);
    open.emplace_back(split, b);
  }
}

/// The intersection of the lines a→b and d→c beyond b and c, if there is one.
std::optional<Vec2> intersection(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const Vec2 u = b - a, v = c - d;
  const double denominator = cross(u, v);
  if (std::abs(denominator) < 1e-3 * u.norm() * v.norm()) return std::nullopt;
  const double along_u = cross(d - a, v) / denominator, along_v = cross(d - a, u) / denominator;
  if (along_u < 1 || along_v < 1) return std::nullopt;
  return a + along_u * u;
}

}  // namespace

double signed_area(const std::vector<Vec2>& polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) sum += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return 0.5 * sum;
}

std::vector<Vec2> simplify(const std::vector<Vec2>& polygon, double tolerance_mm) {
  if (polygon.size() < 4) return polygon;
  std::vector<Vec2> points = polygon;
  const auto lowest = std::min_element(points.begin(), points.end(), [](const Vec2& a, const Vec2& b) {
    return std::pair(a.y(), a.x()) < std::pair(b.y(), b.x());
  });
  std::rotate(points.begin(), lowest, points.end());
  points.push_back(points.front());
  std::size_t opposite = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if ((points[i] - points[0]).norm() > (points[opposite] - points[0]).norm()) opposite = i;
  std::vector<bool> keep(points.size(), false);
  keep.front() = keep[opposite] = true;
  mark_kept(points, 0, opposite, tolerance_mm, keep);
  mark_kept(points, opposite, points.size() - 1, tolerance_mm, keep);
  std::vector<Vec2> kept;
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    if (keep[i]) kept.push_back(points[i]);
  return kept;
}

std::vector<Vec2> sharpen_corners(const std::vector<Vec2>& polygon, double step_mm) {
  const std::size_t n = polygon.size();
  if (n < 5) return polygon;
  const auto at = [&](std::size_t i) -> const Vec2& { return polygon[i % n]; };
  std::vector<std::optional<Vec2>> corner(n);
  std::vector<bool> merged(n, false);
  for (std::size_t i = 0; i < n; ++i) {
    // Vertices a → b → c → d, where edge b → c may cut off a corner.
    const Vec2 &a = at(i + n - 1), &b = at(i), &c = at(i + 1), &d = at(i + 2);
    if ((c - b).norm() > std::numbers::sqrt2 * step_mm) continue;
    if ((b - a).norm() < 3 * step_mm || (d - c).norm() < 3 * step_mm) continue;
    const auto found = intersection(a, b, c, d);
    if (!found || (*found - b).norm() > step_mm || (*found - c).norm() > step_mm) continue;
    corner[i] = Vec2(std::max(0.0, found->x()), found->y());
    merged[(i + 1) % n] = true;
  }
  std::vector<Vec2> out;
  for (std::size_t i = 0; i < n; ++i)
    if (!merged[i]) out.push_back(corner[i].value_or(polygon[i]));
  return out;
}

}  // namespace reamsim
