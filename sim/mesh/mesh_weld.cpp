// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_weld.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

namespace reamsim {

namespace {

/// Of the longest side of the mesh: some hundred times the rounding of single precision, a few µm of a scapula.
constexpr double kRelativeTolerance = 1e-5;
constexpr double kOfShortestEdge = 0.1;
/// Of the largest coordinate: edges below are what rounding left of a collapsed one.
constexpr double kRounding = 4 * std::numeric_limits<float>::epsilon();

using Edge = std::pair<std::int32_t, std::int32_t>;

/// Vertices at edges that belong to one triangle, in order.
std::vector<std::int32_t> rim_vertices(const TriangleMesh& mesh) {
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    for (std::size_t c = 0; c < 3; ++c) edges.push_back(std::minmax(t[c], t[(c + 1) % 3]));
  }
  std::ranges::sort(edges);
  std::vector<std::int32_t> out;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool as_before = i > 0 && edges[i - 1] == edges[i];
    const bool as_next = i + 1 < edges.size() && edges[i + 1] == edges[i];
    if (as_before || as_next || edges[i].first == edges[i].second) continue;
    out.insert(out.end(), {edges[i].first, edges[i].second});
  }
  std::ranges::sort(out);
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

double tolerance_of(const TriangleMesh& mesh) {
  const Aabb box = mesh.bounds();
  const double rounding_mm = kRounding * std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
  double shortest_mm = std::numeric_limits<double>::infinity();
  for (const auto& triangle : mesh.triangles) {
    const auto corners = mesh.corners(triangle);
    for (std::size_t c = 0; c < 3; ++c) {
      const double length_mm = (corners[(c + 1) % 3] - corners[c]).norm();
      if (length_mm > rounding_mm) shortest_mm = std::min(shortest_mm, length_mm);
    }
  }
  return std::min(kRelativeTolerance * (box.max - box.min).maxCoeff(), kOfShortestEdge * shortest_mm);
}

/// Finds the vertex within a tolerance that came first.
class NearVertices {
 public:
  NearVertices(const TriangleMesh& mesh, double tolerance_mm) : mesh_(mesh), tolerance_mm_(tolerance_mm) {}

  /// The nearest earlier one, or the vertex itself, which then is one for the later ones.
  std::int32_t take(std::int32_t vertex) {
    const Vec3& point = at(vertex);
    const std::array<std::int64_t, 3> cell = cell_of(point);
    std::int32_t nearest = vertex;
    double least_mm = tolerance_mm_;
    for (std::int64_t step = 0; step < 27; ++step) {
      const auto found = cells_.find(key({cell[0] + step % 3 - 1, cell[1] + step / 3 % 3 - 1, cell[2] + step / 9 - 1}));
      if (found == cells_.end()) continue;
      for (const std::int32_t other : found->second) {
        const double apart_mm = (at(other) - point).norm();
        if (apart_mm > least_mm) continue;
        least_mm = apart_mm;
        nearest = other;
      }
    }
    if (nearest == vertex) cells_[key(cell)].push_back(vertex);
    return nearest;
  }

 private:
  [[nodiscard]] const Vec3& at(std::int32_t vertex) const { return mesh_.vertices[static_cast<std::size_t>(vertex)]; }
  [[nodiscard]] std::array<std::int64_t, 3> cell_of(const Vec3& point) const {
    const Vec3 cell = (point / tolerance_mm_).array().floor();
    return {std::llround(cell.x()), std::llround(cell.y()), std::llround(cell.z())};
  }
  static std::uint64_t key(const std::array<std::int64_t, 3>& cell) {
    std::uint64_t hash = 1469598103934665603ULL;
    for (const std::int64_t c : cell) hash = (hash ^ static_cast<std::uint64_t>(c)) * 1099511628211ULL;
    return hash;
  }

  const TriangleMesh& mesh_;
  double tolerance_mm_;
  std::unordered_map<std::uint64_t, std::vector<std::int32_t>> cells_;  // other cells of the same key do no harm
};

}  // namespace

namespace {

/// Removes vertices that no triangle has.
void remove_unused(TriangleMesh& mesh) {
  std::vector<std::int32_t> number(mesh.vertices.size(), -1);
  for (const auto& triangle : mesh.triangles) {
    for (const std::int32_t v : triangle) number[static_cast<std::size_t>(v)] = 0;
  }
  std::vector<Vec3> kept;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] < 0) continue;
    number[v] = static_cast<std::int32_t>(kept.size());
    kept.push_back(mesh.vertices[v]);
  }
  mesh.vertices = std::move(kept);
  for (auto& triangle : mesh.triangles) {
    for (std::int32_t& v : triangle) v = number[static_cast<std::size_t>(v)];
  }
}

}  // namespace

WeldResult weld(TriangleMesh& mesh) {
  WeldResult out;
  const std::vector<std::int32_t> rim = rim_vertices(mesh);
  if (rim.empty()) return out;
  out.tolerance_mm = tolerance_of(mesh);
  if (!std::isfinite(out.tolerance_mm) || out.tolerance_mm <= 0) return out;
  std::vector<std::int32_t> target(mesh.vertices.size());
  for (std::size_t v = 0; v < target.size(); ++v) target[v] = static_cast<std::int32_t>(v);
  NearVertices near(mesh, out.tolerance_mm);
  for (const std::int32_t v : rim) {
    const std::int32_t to = near.take(v);
    if (to == v) continue;
    target[static_cast<std::size_t>(v)] = to;
    ++out.corners;
    const double moved_mm =
        (mesh.vertices[static_cast<std::size_t>(v)] - mesh.vertices[static_cast<std::size_t>(to)]).norm();
    out.farthest_mm = std::max(out.farthest_mm, moved_mm);
  }
  if (out.corners == 0) return out;
  for (auto& triangle : mesh.triangles) {
    for (std::int32_t& v : triangle) v = target[static_cast<std::size_t>(v)];
  }
  std::erase_if(mesh.triangles, [](const auto& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  remove_unused(mesh);
  return out;
}

std::string WeldResult::text() const {
  if (corners == 0) return "";
  return fmt::format("{} {} welded that differed by up to {:.2g} mm (tolerance {:.2g} mm)", corners,
                     corners == 1 ? "corner of triangles was" : "corners of triangles were", farthest_mm, tolerance_mm);
}

}  // namespace reamsim
