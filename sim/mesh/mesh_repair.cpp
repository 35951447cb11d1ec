// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_repair.h"

#include <fmt/core.h>
#include <algorithm>
#include <map>
#include <set>

namespace reamsim {

namespace {

using Triangle = std::array<std::int32_t, 3>;
using Loop = std::vector<std::int32_t>;

std::size_t remove_degenerate(std::vector<Triangle>& triangles) {
  std::set<Triangle> seen;
  const std::size_t before = triangles.size();
  std::erase_if(triangles, [&seen](const Triangle& t) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return true;
    Triangle key = t;
    std::sort(key.begin(), key.end());
    return !seen.insert(key).second;
  });
  return before - triangles.size();
}

/// The two triangles at each edge that has two, in the order of the edges; the others are no guide.
struct Neighbours {
  std::size_t first;
  std::size_t second;
  bool opposite;  ///< their orientations differ
};

std::vector<Neighbours> neighbours_in(const std::vector<Triangle>& triangles) {
  struct Uses {
    std::size_t count = 0;
    std::array<std::size_t, 2> triangle{};
    std::array<bool, 2> forward{};
  };
  std::map<std::pair<std::int32_t, std::int32_t>, Uses> edges;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int32_t a = triangles[i][c], b = triangles[i][(c + 1) % 3];
      Uses& uses = edges[std::minmax(a, b)];
      if (uses.count < 2) {
        uses.triangle[uses.count] = i;
        uses.forward[uses.count] = a < b;
      }
      ++uses.count;
    }
  }
  std::vector<Neighbours> out;
  for (const auto& [edge, uses] : edges) {
    if (uses.count == 2) out.push_back({uses.triangle[0], uses.triangle[1], uses.forward[0] == uses.forward[1]});
  }
  return out;
}

/// Turns the triangles of each surface to the orientation that most of them have. A surface with one side only, such
/// as a Moebius strip, some edges stay between opposite orientations.
std::size_t turn_alike(std::vector<Triangle>& triangles) {
  const std::vector<Neighbours> edges = neighbours_in(triangles);
  if (std::ranges::none_of(edges, &Neighbours::opposite)) return 0;
  std::vector<std::vector<std::pair<std::size_t, bool>>> beside(triangles.size());
  for (const Neighbours& edge : edges) {
    beside[edge.first].emplace_back(edge.second, edge.opposite);
    beside[edge.second].emplace_back(edge.first, edge.opposite);
  }
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

/// The boundary edges from each rim vertex. Their direction is opposite to that in their triangle, so that the
/// triangles that close a hole have the orientation of their neighbours.
std::multimap<std::int32_t, std::int32_t> rim_edges(const std::vector<Triangle>& triangles) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> uses;
  for (const Triangle& t : triangles) {
    for (std::size_t c = 0; c < 3; ++c) ++uses[std::minmax(t[c], t[(c + 1) % 3])];
  }
  std::multimap<std::int32_t, std::int32_t> out;
  for (const Triangle& t : triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int32_t a = t[c];
      const std::int32_t b = t[(c + 1) % 3];
      if (uses[std::minmax(a, b)] == 1) out.emplace(b, a);
    }
  }
  return out;
}

/// Follows the rim from its first edge until it closes or ends, and removes these edges from `rim`.
Loop extract_loop(std::multimap<std::int32_t, std::int32_t>& rim) {
  const std::int32_t start = rim.begin()->first;
  Loop loop{start};
  for (std::int32_t at = start;;) {
    const auto edge = rim.find(at);
    if (edge == rim.end()) return loop;
    at = edge->second;
    rim.erase(edge);
    if (at == start) return loop;
    loop.push_back(at);
  }
}

}  // namespace

RepairResult repair(TriangleMesh& mesh) {
  RepairResult out;
  out.dropped_triangles = remove_degenerate(mesh.triangles);
  out.turned_triangles = turn_alike(mesh.triangles);
  auto rim = rim_edges(mesh.triangles);
  while (!rim.empty()) {
    const Loop loop = extract_loop(rim);
    if (loop.size() < 3) continue;
    Vec3 middle = Vec3::Zero();
    for (const std::int32_t v : loop) middle += mesh.vertices[static_cast<std::size_t>(v)];
    middle /= static_cast<double>(loop.size());
    const auto center = static_cast<std::int32_t>(mesh.vertices.size());
    mesh.vertices.push_back(middle);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      mesh.triangles.push_back({loop[i], loop[(i + 1) % loop.size()], center});
      const double reach_mm = (mesh.vertices[static_cast<std::size_t>(loop[i])] - middle).norm();
      out.widest_hole_mm = std::max(out.widest_hole_mm, 2 * reach_mm);
    }
    ++out.closed_holes;
    out.added_triangles += loop.size();
  }
  return out;
}

std::string RepairResult::text() const {
  return fmt::format(
      "{} degenerate triangles removed, {} triangles turned, {} holes closed with {} triangles (largest hole: {:.2f} "
      "mm)",
      dropped_triangles, turned_triangles, closed_holes, added_triangles, widest_hole_mm);
}

}  // namespace reamsim
