// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_holes.h"

#include <fmt/core.h>
#include <algorithm>
#include <map>
#include <utility>

namespace reamsim {

namespace {

/// The next vertices of the rims from each vertex.
using Rims = std::map<std::int32_t, std::vector<std::int32_t>>;

/// The edges that do not cancel. Their direction is opposite to that in their triangles, so that the triangles that
/// close a hole have the orientation of their neighbours.
Rims rims_of(const TriangleMesh& mesh) {
  std::vector<std::pair<std::pair<std::int32_t, std::int32_t>, int>> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int32_t a = t[c], b = t[(c + 1) % 3];
      if (a != b) sides.push_back({std::minmax(a, b), a < b ? 1 : -1});
    }
  }
  std::ranges::sort(sides);
  Rims out;
  for (std::size_t begin = 0; begin < sides.size();) {
    const auto [low, high] = sides[begin].first;
    int sum = 0;
    for (; begin < sides.size() && sides[begin].first == std::pair(low, high); ++begin) sum += sides[begin].second;
    for (; sum > 0; --sum) out[high].push_back(low);
    for (; sum < 0; ++sum) out[low].push_back(high);
  }
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

}  // namespace

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

void close_holes(TriangleMesh& mesh, const std::vector<MeshHole>& holes) {
  for (const MeshHole& hole : holes) {
    const auto centre = static_cast<std::int32_t>(mesh.vertices.size());
    if (hole.rim.size() == 3) {
      mesh.triangles.push_back({hole.rim[0], hole.rim[1], hole.rim[2]});
      continue;
    }
    mesh.vertices.push_back(hole.centre_mm);
    for (std::size_t i = 0; i < hole.rim.size(); ++i) {
      mesh.triangles.push_back({hole.rim[i], hole.rim[(i + 1) % hole.rim.size()], centre});
    }
  }
}

double area_mm2(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& triangle : mesh.triangles) {
    const auto [a, b, c] = mesh.corners(triangle);
    sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

namespace {

double area_of(const std::vector<MeshHole>& holes) {
  double sum = 0;
  for (const MeshHole& hole : holes) sum += hole.area_mm2;
  return sum;
}

}  // namespace

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
