// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/profile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

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

/// The vertices of one profile point; a single one on the axis.
struct Ring {
  std::int32_t first = 0;
  std::int32_t count = 0;

  [[nodiscard]] std::int32_t at(std::int32_t s) const { return first + s % count; }
};

Ring add_ring(TriangleMesh& mesh, const Vec2& rz, int segments) {
  Ring ring{static_cast<std::int32_t>(mesh.vertices.size()), Profile::on_axis(rz) ? 1 : segments};
  for (std::int32_t s = 0; s < ring.count; ++s) {
    const double angle = 2 * std::numbers::pi * s / segments;
    mesh.vertices.emplace_back(rz.x() * std::cos(angle), rz.x() * std::sin(angle), rz.y());
  }
  return ring;
}

/// Tolerance of (r, z) in a ring; 32-bit STL coordinates of a reamer have an error below 1 µm.
constexpr double kRingMm = 2e-3;
constexpr double kSagittaMm = 0.02;  // tolerated sagitta of a facet
/// Tolerated relative difference between the volumes of mesh and revolved polygon; detects partial revolutions.
constexpr double kVolumeTolerance = 0.01;

using Cell = std::pair<long, long>;

double radius_of(const Vec3& p) {
  return std::hypot(p.x(), p.y());
}

/// Groups vertices by (r, z): the ring of each vertex, and each ring's mean position.
class Rings {
 public:
  explicit Rings(const TriangleMesh& mesh) {
    std::vector<Vec2> sums;
    std::vector<double> counts;
    for (const Vec3& p : mesh.vertices) {
      const Vec2 rz(radius_of(p), p.z());
      const std::size_t ring = find_or_add(rz);
      ring_of_.push_back(ring);
      sums.resize(firsts_.size(), Vec2::Zero());
      counts.resize(firsts_.size());
      sums[ring] += rz;
      counts[ring] += 1;
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      Vec2 mean = sums[i] / counts[i];
      if (mean.x() < kRingMm) mean.x() = 0;
      means_.push_back(mean);
    }
  }

  [[nodiscard]] std::size_t of(std::int32_t vertex) const { return ring_of_[static_cast<std::size_t>(vertex)]; }
  [[nodiscard]] const std::vector<Vec2>& means() const { return means_; }

 private:
  std::size_t find_or_add(const Vec2& rz) {
    const long i = std::lround(rz.x() / kRingMm), j = std::lround(rz.y() / kRingMm);
    for (long di = -1; di <= 1; ++di)
      for (long dj = -1; dj <= 1; ++dj) {
        const auto [first, last] = first_in_cell_.equal_range({i + di, j + dj});
        for (auto it = first; it != last; ++it)
          if ((firsts_[it->second] - rz).norm() <= kRingMm) return it->second;
      }
    first_in_cell_.emplace(Cell{i, j}, firsts_.size());
    firsts_.push_back(rz);
    return firsts_.size() - 1;
  }

  std::vector<std::size_t> ring_of_;
  std::vector<Vec2> firsts_, means_;
  std::multimap<Cell, std::size_t> first_in_cell_;
};

using Links = std::vector<std::vector<std::size_t>>;

bool link(Links& links, std::size_t a, std::size_t b) {
  if (a == b) return true;
  if (std::find(links[a].begin(), links[a].end(), b) != links[a].end()) return true;
  links[a].push_back(b);
  links[b].push_back(a);
  return links[a].size() <= 2 && links[b].size() <= 2;
}

/// Whether an edge lies within kSagittaMm of the surface of revolution through its ends.
bool edge_is_fine(const Vec3& a, const Vec3& b) {
  return 0.5 * (radius_of(a) + radius_of(b)) - radius_of(0.5 * (a + b)) <= kSagittaMm;
}

/// The rings that triangles connect; nullopt when a triangle spans three rings or is too coarse, or a ring branches.
std::optional<Links> link_rings(const TriangleMesh& mesh, const Rings& rings) {
  Links links(rings.means().size());
  for (const auto& t : mesh.triangles) {
    const std::size_t a = rings.of(t[0]), b = rings.of(t[1]), c = rings.of(t[2]);
    if (a != b && b != c && c != a) return std::nullopt;
    if (!link(links, a, b) || !link(links, b, c) || !link(links, c, a)) return std::nullopt;
    const auto [p, q, r] = mesh.corners(t);
    if (!edge_is_fine(p, q) || !edge_is_fine(q, r) || !edge_is_fine(r, p)) return std::nullopt;
  }
  return links;
}

/// The rings in order, from an end on the axis or anywhere on a closed chain; nullopt unless the chain has all rings.
std::optional<std::vector<std::size_t>> walk(const Links& links, const std::vector<Vec2>& means) {
  std::size_t start = 0, ends = 0;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (links[i].size() == 2) continue;
    if (links[i].size() != 1 || !Profile::on_axis(means[i])) return std::nullopt;
    start = i;
    ++ends;
  }
  if (ends != 0 && ends != 2) return std::nullopt;
  std::vector<std::size_t> order{start};
  for (std::size_t previous = start, here = links[start][0]; here != start;) {
    order.push_back(here);
    if (links[here].size() == 1) break;
    const std::size_t next = links[here][0] == previous ? links[here][1] : links[here][0];
    previous = std::exchange(here, next);
  }
  if (order.size() != links.size()) return std::nullopt;
  return order;
}

}  // namespace

double Profile::max_radius_mm() const {
  double radius = 0;
  for (const Vec2& p : points) radius = std::max(radius, p.x());
  return radius;
}

Aabb Profile::bounds() const {
  const double radius = max_radius_mm();
  Aabb box = Aabb::none();
  for (const Vec2& p : points) {
    box.extend({radius, radius, p.y()});
    box.extend({-radius, -radius, p.y()});
  }
  return box;
}

Profile::Nearest Profile::nearest(const Vec2& rz) const {
  EdgeDistance best{std::numeric_limits<double>::infinity(), 0, Vec2::Zero(), -Vec2::UnitY()};
  for_each_side(points, [&](const Vec2& a, const Vec2& b) {
    if (a == b || (on_axis(a) && on_axis(b))) return;
    const EdgeDistance d = distance_to_edge(rz, a, b);
    // Two edges that share the nearest vertex tie; the more perpendicular one decides the sign.
    const bool tie = d.squared_mm2 == best.squared_mm2 && std::abs(d.side_mm) > std::abs(best.side_mm);
    if (d.squared_mm2 < best.squared_mm2 || tie) best = d;
  });
  const double distance = std::sqrt(best.squared_mm2);
  const double sign = best.side_mm < 0 ? -1.0 : 1.0;
  if (distance < kOnSurfaceMm) return {sign * distance, best.normal};
  return {sign * distance, sign * best.from_surface / distance};
}

double Profile::volume_mm3() const {
  double sum = 0;
  for_each_side(points, [&sum](const Vec2& a, const Vec2& b) {
    sum += (b.y() - a.y()) * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x());
  });
  return std::numbers::pi / 3 * sum;
}

TriangleMesh revolve(const Profile& profile, int segments) {
  TriangleMesh mesh;
  std::vector<Ring> rings;
  for (const Vec2& rz : profile.points) rings.push_back(add_ring(mesh, rz, segments));
  for (std::size_t p = 0; p < rings.size(); ++p) {
    const Ring& a = rings[p];
    const Ring& b = rings[(p + 1) % rings.size()];
    for (std::int32_t s = 0; s < segments; ++s) {
      if (a.count > 1) mesh.triangles.push_back({a.at(s), a.at(s + 1), b.at(s + 1)});
      if (b.count > 1) mesh.triangles.push_back({a.at(s), b.at(s + 1), b.at(s)});
    }
  }
  return mesh;
}

int segments_for_sagitta(double radius_mm, double sagitta_mm) {
  constexpr int kLeast = 32;
  if (sagitta_mm >= radius_mm) return kLeast;
  const double half_angle = std::acos(1 - sagitta_mm / radius_mm);
  const int quarter = static_cast<int>(std::ceil(std::numbers::pi / half_angle / 4));
  return std::max(kLeast, 4 * quarter);
}

std::optional<Profile> recover_generatrix(const TriangleMesh& mesh) {
  const Rings rings(mesh);
  if (rings.means().size() < 3) return std::nullopt;
  const auto links = link_rings(mesh, rings);
  if (!links) return std::nullopt;
  const auto order = walk(*links, rings.means());
  if (!order) return std::nullopt;
  Profile profile;
  for (const std::size_t ring : *order) profile.points.push_back(rings.means()[ring]);
  if (profile.volume_mm3() < 0) std::reverse(profile.points.begin(), profile.points.end());
  if (std::abs(profile.volume_mm3() - mesh.volume_mm3()) > kVolumeTolerance * profile.volume_mm3()) return std::nullopt;
  return profile;
}

}  // namespace reamsim
