// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_check.h"

#include <fmt/core.h>
#include <algorithm>
#include <numeric>

namespace reamsim {

namespace {

using Triangle = std::array<std::int32_t, 3>;

/// One side of one triangle. `low` < `high`; `forward` if the triangle's order is low, high.
struct Side {
  std::int32_t low = 0;
  std::int32_t high = 0;
  bool forward = false;
  std::size_t triangle = 0;
};

bool collapsed(const Triangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

/// Zero area to within single precision.
bool flat(const TriangleMesh& mesh, const Triangle& t) {
  const auto [a, b, c] = mesh.corners(t);
  const Vec3 ab = b - a, ac = c - a;
  return ab.cross(ac).norm() <= 1e-9 * std::max(ab.squaredNorm(), ac.squaredNorm());
}

std::vector<Side> sorted_sides(const TriangleMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    if (collapsed(t)) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int32_t a = t[c];
      const std::int32_t b = t[(c + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), a < b, i});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) {
    return std::tie(p.low, p.high, p.triangle) < std::tie(q.low, q.high, q.triangle);
  });
  return sides;
}

/// The midpoint of the edge with the smallest triangle index.
struct FirstEdge {
  std::size_t triangle = SIZE_MAX;
  std::optional<Vec3> middle_mm;

  void offer(const TriangleMesh& mesh, const Side& side) {
    if (side.triangle >= triangle) return;
    triangle = side.triangle;
    const auto [low, high, same] = mesh.corners({side.low, side.high, side.high});
    middle_mm = 0.5 * (low + high);
  }
};

std::string at_text(const std::optional<Vec3>& point) {
  if (!point) return "";
  return fmt::format(" (the first at {:.2f}, {:.2f}, {:.2f} mm)", point->x(), point->y(), point->z());
}

std::string count_text(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

}  // namespace

std::vector<std::size_t> components_of(const TriangleMesh& mesh) {
  std::vector<std::size_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](std::int32_t vertex) {
    auto v = static_cast<std::size_t>(vertex);
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : mesh.triangles) {
    for (const std::int32_t v : t) parent[root(v)] = root(t[0]);
  }
  std::vector<std::size_t> number(mesh.vertices.size(), SIZE_MAX);
  std::vector<std::size_t> out;
  std::size_t count = 0;
  for (const Triangle& t : mesh.triangles) {
    std::size_t& component = number[root(t[0])];
    if (component == SIZE_MAX) component = count++;
    out.push_back(component);
  }
  return out;
}

MeshDiagnosis diagnose(const TriangleMesh& mesh) {
  MeshDiagnosis out;
  FirstEdge hole;
  FirstEdge nonmanifold;
  const std::vector<Side> sides = sorted_sides(mesh);
  for (std::size_t begin = 0; begin < sides.size();) {
    std::size_t end = begin + 1;
    while (end < sides.size() && sides[end].low == sides[begin].low && sides[end].high == sides[begin].high) ++end;
    if (end - begin == 1) {
      ++out.boundary_edges;
      hole.offer(mesh, sides[begin]);
    } else if (end - begin > 2) {
      ++out.nonmanifold_edges;
      nonmanifold.offer(mesh, sides[begin]);
    } else if (sides[begin].forward == sides[begin + 1].forward) {
      ++out.inconsistent_edges;
    }
    begin = end;
  }
  out.degenerate_triangles =
      static_cast<std::size_t>(std::count_if(mesh.triangles.begin(), mesh.triangles.end(),
                                             [&mesh](const Triangle& t) { return collapsed(t) || flat(mesh, t); }));
  const std::vector<std::size_t> components = components_of(mesh);
  out.components = components.empty() ? 0 : 1 + *std::max_element(components.begin(), components.end());
  out.volume_mm3 = mesh.volume_mm3();
  out.first_hole_mm = hole.middle_mm;
  out.first_nonmanifold_mm = nonmanifold.middle_mm;
  return out;
}

std::string MeshDiagnosis::text() const {
  std::string out = count_text(boundary_edges, "boundary edge", "boundary edges") + at_text(first_hole_mm) + ", " +
                    count_text(nonmanifold_edges, "non-manifold edge", "non-manifold edges") +
                    at_text(first_nonmanifold_mm);
  if (inconsistent_edges > 0) {
    out += ", " + count_text(inconsistent_edges, "edge", "edges") + " between triangles with opposite orientation";
  }
  if (degenerate_triangles > 0) {
    out += ", " + count_text(degenerate_triangles, "degenerate triangle", "degenerate triangles");
  }
  return out + ", " + count_text(components, "component", "components");
}

}  // namespace reamsim
