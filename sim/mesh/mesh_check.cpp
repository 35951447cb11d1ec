// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_check.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "sim/mesh/winding.h"

namespace reamsim {

namespace {

/// Zero area to within single precision.
bool flat(const TriangleMesh& mesh, const MeshTriangle& t) {
  const auto [a, b, c] = mesh.corners(t);
  const Vec3 ab = b - a, ac = c - a;
  return ab.cross(ac).norm() <= 1e-9 * std::max(ab.squaredNorm(), ac.squaredNorm());
}

/// Counts edges, and keeps the first with the smallest triangle index.
struct EdgeCount {
  std::size_t edges = 0;
  std::optional<EdgeSide> first;

  void add(const EdgeSide& side) {
    ++edges;
    if (!first || side.triangle < first->triangle) first = side;
  }
  [[nodiscard]] std::optional<Vec3> middle_mm(const TriangleMesh& mesh) const {
    if (!first) return std::nullopt;
    return 0.5 * (mesh.vertex(first->low) + mesh.vertex(first->high));
  }
};

std::string at_text(const std::optional<Vec3>& point) {
  if (!point) return "";
  return fmt::format(" (the first at {:.2f}, {:.2f}, {:.2f} mm)", point->x(), point->y(), point->z());
}

/// "1 edge" or "2 edges".
std::string count_text(std::size_t count, const char* one) {
  return fmt::format("{} {}{}", count, one, count == 1 ? "" : "s");
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
  const auto at = [&](std::size_t i) -> const Vec3& { return mesh.vertex(out.rim[i % out.rim.size()]); };
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
  const auto add = [](double sum, const MeshHole& hole) { return sum + hole.area_mm2; };
  return std::accumulate(holes.begin(), holes.end(), 0.0, add);
}

/// The volume of a piece, the volume times its centroid, and its outermost vertices along each axis.
struct PieceSums {
  double volume_mm3 = 0;
  Vec3 moment = Vec3::Zero();
  Aabb box = Aabb::none();
  std::array<Vec3, 6> extreme_mm;

  void add(const Vec3& reference, const std::array<Vec3, 3>& corners) {
    const Vec3 a = corners[0] - reference, b = corners[1] - reference, c = corners[2] - reference;
    const double volume = a.dot(b.cross(c)) / 6;
    volume_mm3 += volume;
    moment += volume * (a + b + c) / 4;
    for (const Vec3& corner : corners) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<Eigen::Index>(axis);
        if (corner[at] < box.min[at]) extreme_mm[2 * axis] = corner;
        if (corner[at] > box.max[at]) extreme_mm[2 * axis + 1] = corner;
      }
      box.extend(corner);
    }
  }

  [[nodiscard]] MeshPiece piece(const Vec3& reference) const {
    const bool solid = std::abs(volume_mm3) > 1e-9 * std::max(box.half().prod() * 8, 1e-300);
    const Vec3 centre = solid ? Vec3(reference + moment / volume_mm3) : Vec3(0.5 * (box.min + box.max));
    return {std::abs(volume_mm3), centre, false, solid && volume_mm3 < 0};
  }
};

/// A piece is inside another, larger one if all of its outermost vertices are: the ray along +z from each crosses the
/// other an odd number of times. Each other counts by itself: an island in a cavity lies in two.
void mark_enclosed(const TriangleMesh& mesh, const std::vector<std::size_t>& piece_of,
                   const std::vector<PieceSums>& sums, std::vector<MeshPiece>& pieces) {
  const LineCrossings lines(mesh, 2);
  for (std::size_t n = 0; n < pieces.size(); ++n) {
    std::map<std::size_t, std::size_t> points_in;
    for (const Vec3& point : sums[n].extreme_mm) {
      std::set<std::size_t> around;
      lines.above(point, [&](std::uint32_t triangle, int) {
        const std::size_t other = piece_of[triangle];
        if (other != n && around.erase(other) == 0) around.insert(other);
      });
      for (const std::size_t other : around) ++points_in[other];
    }
    pieces[n].inside_another = std::ranges::any_of(points_in, [&](const auto& in) {
      // Rounding may put each of two copies of a surface inside the other.
      return in.second == sums[n].extreme_mm.size() && pieces[in.first].volume_mm3 > pieces[n].volume_mm3;
    });
  }
}

std::string text_of(const MeshPiece& piece) {
  return fmt::format("{:.{}f} mm3 at {} mm", piece.volume_mm3, piece.volume_mm3 < 10 ? 2 : 0,
                     point_text(piece.centre_mm));
}

/// The places of the first pieces, the largest, and how many more there are.
std::string places_of(const std::vector<MeshPiece>& pieces) {
  constexpr std::size_t kMostNamed = 3;
  std::string out;
  for (std::size_t n = 0; n < std::min(pieces.size(), kMostNamed); ++n) {
    out += (n == 0 ? "" : ", ") + text_of(pieces[n]);
  }
  return pieces.size() <= kMostNamed ? out : out + fmt::format(" and {} more", pieces.size() - kMostNamed);
}

std::string inward_warning(const std::vector<MeshPiece>& inward, std::size_t outer_count) {
  if (inward.size() == outer_count) return "the triangles of the mesh face inwards; orientation flipped";
  return fmt::format("{} inwards: {}; orientation flipped",
                     inward.size() == 1 ? "the triangles of a piece of the mesh face"
                                        : fmt::format("the triangles of {} pieces of the mesh face", inward.size()),
                     places_of(inward));
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
  boost::disjoint_sets_with_storage<> sets(mesh.vertices.size());
  for (const MeshTriangle& t : mesh.triangles) {
    for (const std::int32_t v : t) sets.union_set(t[0], v);
  }
  std::vector<std::size_t> number(mesh.vertices.size(), SIZE_MAX);
  std::vector<std::size_t> out;
  std::size_t count = 0;
  for (const MeshTriangle& t : mesh.triangles) {
    std::size_t& component = number[sets.find_set(t[0])];
    if (component == SIZE_MAX) component = count++;
    out.push_back(component);
  }
  return out;
}

MeshDiagnosis diagnose(const TriangleMesh& mesh) {
  MeshDiagnosis out;
  EdgeCount boundary, nonmanifold;
  for_each_edge(mesh.triangles, [&](std::span<const EdgeSide> sides) {
    if (sides.size() == 1) boundary.add(sides[0]);
    if (sides.size() > 2) nonmanifold.add(sides[0]);
    if (sides.size() == 2 && sides[0].forward == sides[1].forward) ++out.inconsistent_edges;
  });
  out.boundary_edges = boundary.edges;
  out.nonmanifold_edges = nonmanifold.edges;
  out.degenerate_triangles = static_cast<std::size_t>(std::ranges::count_if(
      mesh.triangles, [&mesh](const MeshTriangle& t) { return is_collapsed(t) || flat(mesh, t); }));
  const std::vector<std::size_t> components = components_of(mesh);
  out.components = components.empty() ? 0 : 1 + *std::ranges::max_element(components);
  out.volume_mm3 = mesh.volume_mm3();
  out.first_hole_mm = boundary.middle_mm(mesh);
  out.first_nonmanifold_mm = nonmanifold.middle_mm(mesh);
  return out;
}

std::string MeshDiagnosis::text() const {
  std::string out = count_text(boundary_edges, "boundary edge") + at_text(first_hole_mm) + ", " +
                    count_text(nonmanifold_edges, "non-manifold edge") + at_text(first_nonmanifold_mm);
  if (inconsistent_edges > 0) {
    out += ", " + count_text(inconsistent_edges, "edge") + " between triangles with opposite orientation";
  }
  if (degenerate_triangles > 0) out += ", " + count_text(degenerate_triangles, "degenerate triangle");
  return out + ", " + count_text(components, "component");
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
  return area_of(holes) <= kSmallHoles * surface_mm2 &&
         std::ranges::all_of(holes, [](const MeshHole& hole) { return hole.width_mm <= kSmallHoleWidth_mm; });
}

std::string text_of(const std::vector<MeshHole>& holes, double surface_mm2) {
  if (holes.empty()) return "no hole";
  const MeshHole& widest = *std::ranges::max_element(holes, {}, &MeshHole::width_mm);
  const double area = area_of(holes);
  const bool one = holes.size() == 1;
  // Two digits, and no exponent.
  const auto two_digits = [](double x) { return x < 10 ? fmt::format("{:.2g}", x) : fmt::format("{:.0f}", x); };
  return fmt::format("{}, {} mm2 ({} % of the surface){}{} mm wide at {} mm", count_text(holes.size(), "hole"),
                     two_digits(area), two_digits(surface_mm2 > 0 ? 100 * area / surface_mm2 : 100),
                     one ? ", " : " together, the widest ", two_digits(widest.width_mm), point_text(widest.centre_mm));
}

NumberedPieces numbered_pieces(const TriangleMesh& mesh) {
  std::vector<std::size_t> piece_of = components_of(mesh);
  const std::size_t count = piece_of.empty() ? 0 : 1 + *std::ranges::max_element(piece_of);
  const Vec3 reference = mesh.bounds().center();
  std::vector<PieceSums> sums(count);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    sums[piece_of[i]].add(reference, mesh.corners(mesh.triangles[i]));
  }
  std::vector<MeshPiece> out;
  for (const PieceSums& piece : sums) out.push_back(piece.piece(reference));
  if (count > 1) mark_enclosed(mesh, piece_of, sums, out);
  return {std::move(out), std::move(piece_of)};
}

std::vector<MeshPiece> turn_outwards(TriangleMesh& mesh, bool all) {
  auto [out, piece_of] = numbered_pieces(mesh);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const MeshPiece& piece = out[piece_of[i]];
    if (piece.faces_inwards && (all || !piece.inside_another)) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
  }
  std::ranges::stable_sort(out, std::greater(), &MeshPiece::volume_mm3);
  return out;
}

TriangleMesh outer_surface(const TriangleMesh& mesh) {
  const auto [pieces, piece_of] = numbered_pieces(mesh);
  TriangleMesh out{mesh.vertices, {}};
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!pieces[piece_of[i]].inside_another) out.triangles.push_back(mesh.triangles[i]);
  }
  return out;
}

double outer_volume_mm3(const std::vector<MeshPiece>& pieces) {
  double sum = 0;
  for (const MeshPiece& piece : pieces) sum += piece.inside_another ? 0 : piece.volume_mm3;
  return sum;
}

std::vector<std::string> warnings_of(const std::vector<MeshPiece>& pieces) {
  std::vector<std::string> out;
  std::vector<MeshPiece> outer = pieces;
  const std::size_t inside = std::erase_if(outer, [](const MeshPiece& piece) { return piece.inside_another; });
  std::vector<MeshPiece> inward = outer;
  std::erase_if(inward, [](const MeshPiece& piece) { return !piece.faces_inwards; });
  if (!inward.empty()) out.push_back(inward_warning(inward, outer.size()));
  if (outer.size() > 1) {
    outer.erase(outer.begin());
    out.push_back(
        fmt::format("the mesh has {} besides the largest: {}; all are kept as bone: remove in the mesh what is no bone",
                    outer.size() == 1 ? "a piece" : fmt::format("{} pieces", outer.size()), places_of(outer)));
  }
  if (inside > 0) {
    out.push_back(fmt::format("the mesh has {} inside another; a surface inside another does not create a cavity",
                              inside == 1 ? "a surface" : fmt::format("{} surfaces", inside)));
  }
  return out;
}

}  // namespace reamsim
