// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_check.h"

#include <fmt/core.h>
#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

namespace reamsim {

namespace {

/// Zero area to within single precision.
bool flat(const TriangleMesh& mesh, const MeshTriangle& t) {
  const auto [a, b, c] = mesh.corners(t);
  const Vec3 ab = b - a, ac = c - a;
  return ab.cross(ac).norm() <= 1e-9 * std::max(ab.squaredNorm(), ac.squaredNorm());
}

/// The midpoint of the edge with the smallest triangle index.
struct FirstEdge {
  std::uint32_t triangle = UINT32_MAX;
  std::optional<Vec3> middle_mm;

  void offer(const TriangleMesh& mesh, const EdgeSide& side) {
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

/// The next vertices of the rims from each vertex.
using Rims = std::map<std::int32_t, std::vector<std::int32_t>>;

/// The edges that do not cancel. Their direction is opposite to that in their triangles, so that the triangles that
/// close a hole have the orientation of their neighbours.
Rims rims_of(const TriangleMesh& mesh) {
  Rims out;
  for_each_edge(mesh.triangles, [&](std::span<const EdgeSide> sides) {
    int sum = 0;
    for (const EdgeSide& side : sides) sum += side.forward ? 1 : -1;
    for (; sum > 0; --sum) out[sides[0].high].push_back(sides[0].low);
    for (; sum < 0; ++sum) out[sides[0].low].push_back(sides[0].high);
  });
  return out;
}

/// Follows the rims from `start` and cuts a loop off wherever they meet themselves.
void take_loops(Rims& rims, std::int32_t start, std::vector<std::vector<std::int32_t>>& loops) {
  std::vector<std::int32_t> way{start};
  std::map<std::int32_t, std::size_t> place{{start, 0}};
  for (auto next = rims.find(start); next != rims.end() && !next->second.empty(); next = rims.find(way.back())) {
    const std::int32_t to = next->second.back();
    next->second.pop_back();
    const auto met = place.find(to);
    if (met == place.end()) {
      place[to] = way.size();
      way.push_back(to);
      continue;
    }
    const std::size_t first = met->second;
    loops.emplace_back(way.begin() + static_cast<std::ptrdiff_t>(first), way.end());
    for (std::size_t i = first + 1; i < way.size(); ++i) place.erase(way[i]);
    way.resize(first + 1);
  }
}

MeshHole measured(const TriangleMesh& mesh, std::vector<std::int32_t> rim) {
  MeshHole out{.rim = std::move(rim)};
  const auto at = [&](std::size_t i) -> const Vec3& {
    return mesh.vertices[static_cast<std::size_t>(out.rim[i % out.rim.size()])];
  };
  for (std::size_t i = 0; i < out.rim.size(); ++i) out.centre_mm += at(i) / static_cast<double>(out.rim.size());
  Mat3 spread = Mat3::Zero();
  for (std::size_t i = 0; i < out.rim.size(); ++i) {
    const Vec3 from = at(i) - out.centre_mm;
    spread += from * from.transpose();
    out.area_mm2 += 0.5 * from.cross(at(i + 1) - out.centre_mm).norm();
    out.length_mm = std::max(out.length_mm, 2 * from.norm());
  }
  const Vec3 second = symmetric_eigen(spread).vectors.col(1);
  double least = 0, most = 0;
  for (std::size_t i = 0; i < out.rim.size(); ++i) {
    const double along = second.dot(at(i) - out.centre_mm);
    least = std::min(least, along);
    most = std::max(most, along);
  }
  out.width_mm = most - least;
  return out;
}

double area_of(const std::vector<MeshHole>& holes) {
  double sum = 0;
  for (const MeshHole& hole : holes) sum += hole.area_mm2;
  return sum;
}

}  // namespace

std::vector<EdgeSide> sorted_sides(const std::vector<MeshTriangle>& triangles) {
  std::vector<EdgeSide> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const MeshTriangle& t = triangles[i];
    if (is_collapsed(t)) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto [low, high] = std::minmax(t[c], t[(c + 1) % 3]);
      sides.push_back({low, high, t[c] == low, static_cast<std::uint32_t>(i)});
    }
  }
  std::ranges::sort(sides, {}, [](const EdgeSide& side) { return std::tuple(side.low, side.high, side.triangle); });
  return sides;
}

std::vector<std::size_t> components_of(const TriangleMesh& mesh) {
  std::vector<std::size_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](std::int32_t vertex) {
    auto v = static_cast<std::size_t>(vertex);
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const MeshTriangle& t : mesh.triangles) {
    for (const std::int32_t v : t) parent[root(v)] = root(t[0]);
  }
  std::vector<std::size_t> number(mesh.vertices.size(), SIZE_MAX);
  std::vector<std::size_t> out;
  std::size_t count = 0;
  for (const MeshTriangle& t : mesh.triangles) {
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
  for_each_edge(mesh.triangles, [&](std::span<const EdgeSide> sides) {
    if (sides.size() == 1) {
      ++out.boundary_edges;
      hole.offer(mesh, sides[0]);
    } else if (sides.size() > 2) {
      ++out.nonmanifold_edges;
      nonmanifold.offer(mesh, sides[0]);
    } else if (sides[0].forward == sides[1].forward) {
      ++out.inconsistent_edges;
    }
  });
  out.degenerate_triangles = static_cast<std::size_t>(std::ranges::count_if(
      mesh.triangles, [&mesh](const MeshTriangle& t) { return is_collapsed(t) || flat(mesh, t); }));
  const std::vector<std::size_t> components = components_of(mesh);
  out.components = components.empty() ? 0 : 1 + *std::ranges::max_element(components);
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

std::vector<MeshHole> holes_of(const TriangleMesh& mesh) {
  Rims rims = rims_of(mesh);
  std::vector<std::vector<std::int32_t>> loops;
  for (auto& [vertex, next] : rims) {
    while (!next.empty()) take_loops(rims, vertex, loops);
  }
  std::vector<MeshHole> out;
  for (auto& loop : loops) out.push_back(measured(mesh, std::move(loop)));
  std::ranges::stable_sort(out, [](const MeshHole& a, const MeshHole& b) { return a.area_mm2 > b.area_mm2; });
  return out;
}

bool are_small(const std::vector<MeshHole>& holes, double surface_mm2) {
  return area_of(holes) <= HoleLimits::kMostOfArea * surface_mm2 &&
         std::ranges::all_of(holes, [](const MeshHole& hole) { return hole.width_mm <= HoleLimits::kMostWidth_mm; });
}

std::string text_of(const std::vector<MeshHole>& holes, double surface_mm2) {
  if (holes.empty()) return "no hole";
  const MeshHole& widest = *std::ranges::max_element(holes, {}, &MeshHole::width_mm);
  const double area = area_of(holes);
  const Vec3& c = widest.centre_mm;
  const bool one = holes.size() == 1;
  // Two digits, and no exponent.
  const auto two_digits = [](double x) { return x < 10 ? fmt::format("{:.2g}", x) : fmt::format("{:.0f}", x); };
  return fmt::format("{}, {} mm2 ({} % of the surface){}{} mm wide at ({:.1f}, {:.1f}, {:.1f}) mm",
                     one ? "1 hole" : fmt::format("{} holes", holes.size()), two_digits(area),
                     two_digits(surface_mm2 > 0 ? 100 * area / surface_mm2 : 100),
                     one ? ", " : " together, the widest ", two_digits(widest.width_mm), c.x(), c.y(), c.z());
}

}  // namespace reamsim
