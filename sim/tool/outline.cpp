// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "sim/bone/implicit.h"

namespace reamsim {

namespace {

constexpr std::size_t kMinVertices = 4;  // any three lie on a circle
/// More than 90°, so that the half circle of a sphere needs two arcs wherever its vertices lie; must be less than 180°.
constexpr double kLargestArc = std::numbers::pi * 100 / 180;

/// A vector rotated by 90° to the right: the outward normal of a direction along an outline.
Vec2 right_of(const Vec2& v) {
  return {v.y(), -v.x()};
}

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

OutlineArc line(const Vec2& a, const Vec2& b) {
  const Vec2 along = (b - a).normalized();
  return {a, b, along, along, 0.5 * (a + b), right_of(along), 0};
}

/// A circle; its curvature is positive for a left turn.
struct Circle {
  Vec2 center;
  double curvature;
};

std::optional<Circle> circle_through(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 u = b - a, v = c - a;
  const double turn = cross(u, v);
  if (std::abs(turn) < 1e-9 * u.norm() * v.norm()) return std::nullopt;
  const Vec2 to_center =
      Vec2(v.y() * u.squaredNorm() - u.y() * v.squaredNorm(), u.x() * v.squaredNorm() - v.x() * u.squaredNorm()) /
      (2 * turn);
  return Circle{a + to_center, std::copysign(1 / to_center.norm(), turn)};
}

/// The arc through a sequence of vertices, if all lie on one.
std::optional<OutlineArc> arc_through(std::span<const Vec2> points) {
  const auto circle = circle_through(points.front(), points[points.size() / 2], points.back());
  if (!circle) return std::nullopt;
  const double radius = 1 / std::abs(circle->curvature), side = std::copysign(1.0, circle->curvature);
  double turned = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::abs((points[i] - circle->center).norm() - radius) > kOnArcMm) return std::nullopt;
    if (i == 0) continue;
    const double turn = angle_between(points[i - 1] - circle->center, points[i] - circle->center);
    if (turn * side <= 0 || std::abs(turn) > kSharpTurn) return std::nullopt;
    turned += turn;
  }
  if (std::abs(turned) > kLargestArc + 1e-6) return std::nullopt;
  // Away from the centre where the outline is convex, towards it where it is concave.
  const auto normal_at = [&](const Vec2& p) -> Vec2 { return side * (p - circle->center).normalized(); };
  const auto along_at = [&](const Vec2& p) -> Vec2 { return -right_of(normal_at(p)); };
  const Vec2 &a = points.front(), &b = points.back();
  const Vec2 normal = (normal_at(a) + normal_at(b)).normalized();
  return OutlineArc{a, b, along_at(a), along_at(b), circle->center + side * radius * normal, normal, circle->curvature};
}

/// The profile's vertices as polylines off the axis, without repeated points.
std::vector<std::vector<Vec2>> polylines_of(const Profile& profile) {
  const std::vector<Vec2>& points = profile.points;
  const std::size_t n = points.size();
  const auto is_surface = [&](std::size_t i) {
    const Vec2 &a = points[i % n], &b = points[(i + 1) % n];
    return a.cast<float>() != b.cast<float>() && !(Profile::on_axis(a) && Profile::on_axis(b));
  };
  std::size_t first = 0;
  while (first < n && is_surface(first + n - 1)) ++first;
  if (first == n) first = 0;
  std::vector<std::vector<Vec2>> rows;
  bool open = false;
  for (std::size_t k = first; k < first + n; ++k) {
    const Vec2 &a = points[k % n], &b = points[(k + 1) % n];
    if (a.cast<float>() == b.cast<float>()) continue;
    if (!is_surface(k)) {
      open = false;
      continue;
    }
    if (!open) rows.push_back({a});
    rows.back().push_back(b);
    open = true;
  }
  return rows;
}

/// The number of vertices on the longest arc from vertex `first` on, 0 for none.
std::size_t longest_arc(std::span<const Vec2> row, std::size_t first) {
  std::size_t n = kMinVertices;
  while (first + n <= row.size() && arc_through(row.subspan(first, n))) ++n;
  return n == kMinVertices ? 0 : n - 1;
}

/// Marks the points of points[first…last] to keep, without the ends.
void mark_kept(const std::vector<Vec2>& points, std::size_t first, std::size_t last, double tolerance,
               std::vector<bool>& keep) {
  double farthest = tolerance;
  std::size_t split = 0;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double d = implicit::distance_to_segment(points[i], points[first], points[last]);
    if (d <= farthest) continue;
    farthest = d;
    split = i;
  }
  if (split == 0) return;
  keep[split] = true;
  mark_kept(points, first, split, tolerance, keep);
  mark_kept(points, split, last, tolerance, keep);
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

double angle_between(const Vec2& a, const Vec2& b) {
  return std::atan2(cross(a, b), a.dot(b));
}

double OutlineArc::length() const {
  const double chord = (end - begin).norm();
  if (curvature == 0) return chord;
  return 2 / std::abs(curvature) * std::asin(std::min(1.0, 0.5 * chord * std::abs(curvature)));
}

double OutlineArc::distance(const Vec2& rz) const {
  const bool before = (rz - begin).dot(along_begin)<0, past = (rz - end).dot(along_end)> 0;
  if (before || past) return std::min((rz - begin).norm(), (rz - end).norm());
  const Vec2 w = rz - middle;
  const double q = curvature * w.squaredNorm() + 2 * w.dot(normal);
  return std::abs(q / (1 + std::sqrt(std::max(0.0, 1 + curvature * q))));
}

Outline fit_outline(const Profile& profile) {
  Outline out;
  for (const std::vector<Vec2>& row : polylines_of(profile)) {
    for (std::size_t i = 0; i + 1 < row.size();) {
      const std::size_t count = longest_arc(row, i);
      if (count == 0) {
        out.arcs.push_back(line(row[i], row[i + 1]));
        ++i;
        continue;
      }
      out.arcs.push_back(*arc_through(std::span(row).subspan(i, count)));
      for (std::size_t k = i; k + 1 < i + count; ++k) {
        const double chord_mm = (row[k + 1] - row[k]).norm();
        const double sagitta_mm = std::abs(out.arcs.back().curvature) * chord_mm * chord_mm / 8;
        out.bulge_mm = std::max(out.bulge_mm, kOnArcMm + sagitta_mm);
      }
      i += count - 1;
    }
  }
  return out;
}

double signed_area(const std::vector<Vec2>& polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) sum += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return 0.5 * sum;
}

std::vector<Vec2> simplify(const std::vector<Vec2>& polygon, double tolerance_mm) {
  if (polygon.size() < 4) return polygon;
  std::vector<Vec2> points = polygon;
  const auto lowest = std::ranges::min_element(points, {}, [](const Vec2& p) { return std::pair(p.y(), p.x()); });
  std::rotate(points.begin(), lowest, points.end());
  points.push_back(points.front());
  const auto away = [&](const Vec2& p) { return (p - points[0]).norm(); };
  const auto opposite = static_cast<std::size_t>(std::ranges::max_element(points, {}, away) - points.begin());
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
