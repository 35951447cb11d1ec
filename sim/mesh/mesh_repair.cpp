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
  return fmt::format("{} degenerate triangles removed, {} holes closed with {} triangles (largest hole: {:.2f} mm)",
                     dropped_triangles, closed_holes, added_triangles, widest_hole_mm);
}

}  // namespace reamsim
