// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_check.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <boost/functional/hash.hpp>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <unordered_map>
#include <utility>

namespace reamsim {

namespace {

/// The vertices of a triangle in order: the same for all triangles that lie on each other.
MeshTriangle place_of(MeshTriangle t) {
  std::ranges::sort(t);
  return t;
}

/// Whether the order of the vertices is an even permutation of that of place_of().
bool is_forward(const MeshTriangle& t) {
  const MeshTriangle sorted = place_of(t);
  const auto first = static_cast<std::size_t>(std::ranges::find(t, sorted[0]) - t.begin());
  return t[(first + 1) % 3] == sorted[1];
}

using Edge = std::pair<std::int32_t, std::int32_t>;

std::array<Edge, 3> edges_of(const MeshTriangle& t) {
  return {std::minmax(t[0], t[1]), std::minmax(t[1], t[2]), std::minmax(t[2], t[0])};
}

/// The places of balanced triangles (as many forward as backward) that are needed: groups that share edges, at most of
/// whose outer edges the other triangles leave a hole; or that have no outer edge, as a surface with two sides.
std::set<MeshTriangle> needed_places(const std::map<MeshTriangle, int>& balance) {
  std::map<Edge, std::vector<MeshTriangle>> balanced;
  std::map<Edge, std::size_t> others;
  for (const auto& [place, sum] : balance) {
    for (const Edge& edge : edges_of(place)) {
      others[edge] += sum == 0 ? 0 : 1;
      if (sum == 0) balanced[edge].push_back(place);
    }
  }
  std::set<MeshTriangle> visited, needed;
  for (const auto& [start, start_sum] : balance) {
    if (start_sum != 0 || !visited.insert(start).second) continue;
    std::vector<MeshTriangle> group{start};
    std::size_t outer = 0, open = 0;
    for (std::size_t n = 0; n < group.size(); ++n) {
      for (const Edge& edge : edges_of(group[n])) {
        const std::vector<MeshTriangle>& beside = balanced[edge];
        if (beside.size() == 1) {
          ++outer;
          open += others[edge] % 2;
        }
        std::ranges::copy_if(beside, std::back_inserter(group),
                             [&](const auto& p) { return visited.insert(p).second; });
      }
    }
    if (2 * open >= outer) needed.insert(group.begin(), group.end());
  }
  return needed;
}

/// Removes collapsed triangles, and all but one at each place; of balanced ones also that, unless it is needed.
std::size_t remove_degenerate(std::vector<MeshTriangle>& triangles) {
  const std::size_t before = triangles.size();
  std::erase_if(triangles, is_collapsed);
  std::map<MeshTriangle, int> balance;
  for (const MeshTriangle& t : triangles) balance[place_of(t)] += is_forward(t) ? 1 : -1;
  if (balance.size() == triangles.size()) return before - triangles.size();
  const std::set<MeshTriangle> needed = needed_places(balance);
  std::set<MeshTriangle> seen;
  std::erase_if(triangles, [&](const MeshTriangle& t) {
    const MeshTriangle place = place_of(t);
    const int sum = balance[place];
    if (sum == 0 ? !needed.contains(place) : is_forward(t) != (sum > 0)) return true;
    return !seen.insert(place).second;
  });
  return before - triangles.size();
}

/// Turns the triangles of each surface to the orientation that most of them have. A surface with one side only, such
/// as a Moebius strip, some edges stay between opposite orientations.
std::size_t turn_alike(std::vector<MeshTriangle>& triangles) {
  std::vector<std::vector<std::pair<std::size_t, bool>>> beside(triangles.size());  // and whether it is opposite
  bool any_opposite = false;
  for_each_edge(triangles, [&](std::span<const EdgeSide> sides) {
    if (sides.size() != 2) return;  // no guide
    const bool opposite = sides[0].forward == sides[1].forward;
    any_opposite |= opposite;
    beside[sides[0].triangle].emplace_back(sides[1].triangle, opposite);
    beside[sides[1].triangle].emplace_back(sides[0].triangle, opposite);
  });
  if (!any_opposite) return 0;
  constexpr int kUnknown = -1;
  std::vector<int> turned(triangles.size(), kUnknown);
  std::size_t count = 0;
  for (std::size_t seed = 0; seed < triangles.size(); ++seed) {
    if (turned[seed] != kUnknown) continue;
    turned[seed] = 0;
    std::vector<std::size_t> surface{seed};
    for (std::size_t n = 0; n < surface.size(); ++n) {
      for (const auto& [other, opposite] : beside[surface[n]]) {
        if (turned[other] != kUnknown) continue;
        turned[other] = opposite ? 1 - turned[surface[n]] : turned[surface[n]];
        surface.push_back(other);
      }
    }
    const auto ones = static_cast<std::size_t>(std::ranges::count_if(surface, [&](auto i) { return turned[i] == 1; }));
    const int minority = 2 * ones > surface.size() ? 0 : 1;
    for (const std::size_t i : surface) {
      if (turned[i] != minority) continue;
      std::swap(triangles[i][1], triangles[i][2]);
      ++count;
    }
  }
  return count;
}

/// Of the longest side of the mesh: some hundred times the rounding of single precision, a few µm of a scapula.
constexpr double kRelativeTolerance = 1e-5;
constexpr double kOfShortestEdge = 0.1;
/// Of the largest coordinate: edges below are what rounding left of a collapsed one.
constexpr double kRounding = 4 * std::numeric_limits<float>::epsilon();

/// Vertices at edges that belong to one triangle, in order.
std::vector<std::int32_t> rim_vertices(const TriangleMesh& mesh) {
  std::vector<std::int32_t> out;
  for_each_edge(mesh.triangles, [&](std::span<const EdgeSide> sides) {
    if (sides.size() == 1) out.insert(out.end(), {sides[0].low, sides[0].high});
  });
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
    const Vec3& point = mesh_.vertex(vertex);
    const Vec3 place = (point / tolerance_mm_).array().floor();
    const Cell cell{std::llround(place.x()), std::llround(place.y()), std::llround(place.z())};
    std::int32_t nearest = vertex;
    double least_mm = tolerance_mm_;
    for (std::int64_t step = 0; step < 27; ++step) {
      const auto found = cells_.find({cell[0] + step % 3 - 1, cell[1] + step / 3 % 3 - 1, cell[2] + step / 9 - 1});
      if (found == cells_.end()) continue;
      for (const std::int32_t other : found->second) {
        const double apart_mm = (mesh_.vertex(other) - point).norm();
        if (apart_mm > least_mm) continue;
        least_mm = apart_mm;
        nearest = other;
      }
    }
    if (nearest == vertex) cells_[cell].push_back(vertex);
    return nearest;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;

  const TriangleMesh& mesh_;
  double tolerance_mm_;
  std::unordered_map<Cell, std::vector<std::int32_t>, boost::hash<Cell>> cells_;
};

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

RepairResult clean(TriangleMesh& mesh) {
  RepairResult out;
  out.dropped_triangles = remove_degenerate(mesh.triangles);
  out.turned_triangles = turn_alike(mesh.triangles);
  return out;
}

void close_holes(TriangleMesh& mesh, const std::vector<MeshHole>& holes, RepairResult& done) {
  const std::size_t before = mesh.triangles.size();
  for (const MeshHole& hole : holes) {
    done.widest_hole_mm = std::max(done.widest_hole_mm, hole.length_mm);
    if (hole.rim.size() == 3) {
      mesh.triangles.push_back({hole.rim[0], hole.rim[1], hole.rim[2]});
      continue;
    }
    const auto centre = static_cast<std::int32_t>(mesh.vertices.size());
    mesh.vertices.push_back(hole.centre_mm);
    for (std::size_t i = 0; i < hole.rim.size(); ++i) {
      mesh.triangles.push_back({hole.rim[i], hole.rim[(i + 1) % hole.rim.size()], centre});
    }
  }
  done.closed_holes = holes.size();
  done.added_triangles = mesh.triangles.size() - before;
}

std::string RepairResult::text() const {
  return fmt::format(
      "{} collapsed or doubled triangles removed, {} triangles turned, {} holes closed with {} triangles (largest "
      "hole: {:.2f} mm)",
      dropped_triangles, turned_triangles, closed_holes, added_triangles, widest_hole_mm);
}

std::string weld(TriangleMesh& mesh) {
  const std::vector<std::int32_t> rim = rim_vertices(mesh);
  const double tolerance_mm = rim.empty() ? 0 : tolerance_of(mesh);
  if (!std::isfinite(tolerance_mm) || tolerance_mm <= 0) return "";
  std::vector<std::int32_t> target(mesh.vertices.size());
  std::iota(target.begin(), target.end(), 0);
  NearVertices near(mesh, tolerance_mm);
  std::size_t corners = 0;
  double farthest_mm = 0;
  for (const std::int32_t v : rim) {
    const std::int32_t to = near.take(v);
    if (to == v) continue;
    target[static_cast<std::size_t>(v)] = to;
    ++corners;
    farthest_mm = std::max(farthest_mm, (mesh.vertex(v) - mesh.vertex(to)).norm());
  }
  if (corners == 0) return "";
  for (auto& triangle : mesh.triangles) {
    for (std::int32_t& v : triangle) v = target[static_cast<std::size_t>(v)];
  }
  std::erase_if(mesh.triangles, is_collapsed);
  remove_unused(mesh);
  return fmt::format("{} {} welded that differed by up to {:.2g} mm (tolerance {:.2g} mm)", corners,
                     corners == 1 ? "corner of triangles was" : "corners of triangles were", farthest_mm, tolerance_mm);
}

}  // namespace reamsim
