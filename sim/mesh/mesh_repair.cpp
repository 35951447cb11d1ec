// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_repair.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "sim/mesh/mesh_check.h"
#include "sim/mesh/mesh_holes.h"

namespace reamsim {

namespace {

using Triangle = std::array<std::int32_t, 3>;

/// The vertices of a triangle in order: the same for all triangles that lie on each other.
Triangle place_of(Triangle t) {
  std::ranges::sort(t);
  return t;
}

/// Whether the order of the vertices is an even permutation of that of place_of().
bool is_forward(const Triangle& t) {
  const Triangle sorted = place_of(t);
  const auto first = static_cast<std::size_t>(std::ranges::find(t, sorted[0]) - t.begin());
  return t[(first + 1) % 3] == sorted[1];
}

using Edge = std::pair<std::int32_t, std::int32_t>;

std::array<Edge, 3> edges_of(const Triangle& t) {
  return {std::minmax(t[0], t[1]), std::minmax(t[1], t[2]), std::minmax(t[2], t[0])};
}

/// The places of balanced triangles, as many forward as backward, that are needed: groups of them that share edges, and
/// at most of whose outer edges the other triangles leave a hole; or that have no outer edge, as a surface with two
/// sides.
class NeededPlaces {
 public:
  NeededPlaces(const std::map<Triangle, int>& balance) {
    for (const auto& [place, sum] : balance) {
      for (const Edge& edge : edges_of(place)) (sum == 0 ? balanced_[edge] : others_[edge]).push_back(place);
    }
    for (const auto& [place, sum] : balance) {
      if (sum == 0 && !visited_.contains(place)) visit(place);
    }
  }
  [[nodiscard]] bool contains(const Triangle& place) const { return needed_.contains(place); }

 private:
  void visit(const Triangle& start) {
    std::vector<Triangle> group{start};
    visited_.insert(start);
    std::size_t outer = 0, open = 0;
    for (std::size_t n = 0; n < group.size(); ++n) {
      for (const Edge& edge : edges_of(Triangle(group[n]))) {
        const std::vector<Triangle>& beside = balanced_[edge];
        if (beside.size() == 1) {
          const auto others = others_.find(edge);
          const std::size_t count = others == others_.end() ? 0 : others->second.size();
          ++outer;
          open += count % 2;
        }
        for (const Triangle& next : beside) {
          if (visited_.insert(next).second) group.push_back(next);
        }
      }
    }
    if (2 * open >= outer) needed_.insert(group.begin(), group.end());
  }

  std::map<Edge, std::vector<Triangle>> balanced_, others_;
  std::set<Triangle> visited_, needed_;
};

/// Removes collapsed triangles, and all but one at each place; of balanced ones also that, unless it is needed.
std::size_t remove_degenerate(std::vector<Triangle>& triangles) {
  const std::size_t before = triangles.size();
  std::erase_if(triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  std::map<Triangle, int> balance;
  for (const Triangle& t : triangles) balance[place_of(t)] += is_forward(t) ? 1 : -1;
  if (balance.size() == triangles.size()) return before - triangles.size();
  const NeededPlaces needed(balance);
  std::set<Triangle> seen;
  std::erase_if(triangles, [&](const Triangle& t) {
    const Triangle place = place_of(t);
    const int sum = balance[place];
    if (sum == 0 ? !needed.contains(place) : is_forward(t) != (sum > 0)) return true;
    return !seen.insert(place).second;
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

}  // namespace

RepairResult clean(TriangleMesh& mesh) {
  RepairResult out;
  out.dropped_triangles = remove_degenerate(mesh.triangles);
  out.turned_triangles = turn_alike(mesh.triangles);
  return out;
}

RepairResult repair(TriangleMesh& mesh) {
  RepairResult out = clean(mesh);
  const std::vector<Neighbours> edges = neighbours_in(mesh.triangles);
  if (std::ranges::any_of(edges, &Neighbours::opposite)) return out;
  const std::vector<MeshHole> holes = holes_of(mesh);
  const std::size_t before = mesh.triangles.size();
  close_holes(mesh, holes);
  out.closed_holes = holes.size();
  out.added_triangles = mesh.triangles.size() - before;
  for (const MeshHole& hole : holes) out.widest_hole_mm = std::max(out.widest_hole_mm, hole.length_mm);
  return out;
}

std::string RepairResult::text() const {
  return fmt::format(
      "{} collapsed or doubled triangles removed, {} triangles turned, {} holes closed with {} triangles (largest "
      "hole: {:.2f} "
      "mm)",
      dropped_triangles, turned_triangles, closed_holes, added_triangles, widest_hole_mm);
}

namespace {

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

/// A point of a piece, and the other pieces that the ray along +z from it crosses an odd number of times: those around
/// it. Each counts by itself: an island in a cavity lies in two.
struct Probe {
  Vec3 point;
  std::size_t piece;
  std::vector<std::size_t> around = {};

  void cross(std::size_t other) {
    const auto found = std::ranges::find(around, other);
    if (found == around.end()) {
      around.push_back(other);
    } else {
      around.erase(found);
    }
  }
};

/// Whether the ray along +z from a point meets a triangle. Edges belong to one of their two triangles.
bool is_below(const Vec3& p, const std::array<Vec3, 3>& t) {
  bool inside = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 &a = t[i], &b = t[(i + 1) % 3];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    const Vec3 &low = a.y() < b.y() ? a : b, &high = a.y() < b.y() ? b : a;  // the same arithmetic for both triangles
    if (p.x() < low.x() + (p.y() - low.y()) / (high.y() - low.y()) * (high.x() - low.x())) inside = !inside;
  }
  if (!inside) return false;
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  return normal.z() != 0 && normal.dot(t[0] - p) / normal.z() > 0;
}

/// Finds the pieces around each probe: one pass over the triangles, with the probes sorted by x.
void find_around(const TriangleMesh& mesh, const std::vector<std::size_t>& piece_of, std::vector<Probe>& probes) {
  std::ranges::sort(probes, {}, [](const Probe& probe) { return probe.point.x(); });
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(mesh.triangles[i]);
    const auto [least, most] = std::minmax({a.x(), b.x(), c.x()});
    auto probe = std::ranges::lower_bound(probes, least, {}, [](const Probe& p) { return p.point.x(); });
    for (; probe != probes.end() && probe->point.x() <= most; ++probe) {
      if (probe->piece != piece_of[i] && is_below(probe->point, {a, b, c})) probe->cross(piece_of[i]);
    }
  }
}

/// A piece is inside another, larger one if its outermost vertices are.
void mark_enclosed(const TriangleMesh& mesh, const std::vector<std::size_t>& piece_of,
                   const std::vector<PieceSums>& sums, std::vector<MeshPiece>& pieces) {
  std::vector<Probe> probes;
  for (std::size_t n = 0; n < sums.size(); ++n) {
    for (const Vec3& point : sums[n].extreme_mm) probes.push_back({point, n});
  }
  find_around(mesh, piece_of, probes);
  std::vector<std::map<std::size_t, std::size_t>> points_in(pieces.size());  // of each piece, by the piece around them
  for (const Probe& probe : probes) {
    for (const std::size_t other : probe.around) ++points_in[probe.piece][other];
  }
  for (std::size_t n = 0; n < pieces.size(); ++n) {
    pieces[n].inside_another = std::ranges::any_of(points_in[n], [&](const auto& in) {
      // Rounding may put each of two copies of a surface inside the other.
      return in.second == sums[n].extreme_mm.size() && pieces[in.first].volume_mm3 > pieces[n].volume_mm3;
    });
  }
}

std::string text_of(const MeshPiece& piece) {
  const Vec3& c = piece.centre_mm;
  return fmt::format("{:.{}f} mm3 at ({:.1f}, {:.1f}, {:.1f}) mm", piece.volume_mm3, piece.volume_mm3 < 10 ? 2 : 0,
                     c.x(), c.y(), c.z());
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

std::vector<MeshPiece> chosen(const std::vector<MeshPiece>& pieces, bool (*wanted)(const MeshPiece&)) {
  std::vector<MeshPiece> out;
  std::ranges::copy_if(pieces, std::back_inserter(out), wanted);
  return out;
}

std::string inward_warning(const std::vector<MeshPiece>& inward, std::size_t outer_count) {
  if (inward.size() == outer_count) return "the triangles of the mesh face inwards; orientation flipped";
  return fmt::format("{} inwards: {}; orientation flipped",
                     inward.size() == 1 ? "the triangles of a piece of the mesh face"
                                        : fmt::format("the triangles of {} pieces of the mesh face", inward.size()),
                     places_of(inward));
}

/// The pieces in the order of components_of().
std::vector<MeshPiece> pieces_in_order(const TriangleMesh& mesh, const std::vector<std::size_t>& piece_of) {
  const std::size_t count = piece_of.empty() ? 0 : 1 + *std::ranges::max_element(piece_of);
  const Vec3 reference = mesh.bounds().center();
  std::vector<PieceSums> sums(count);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    sums[piece_of[i]].add(reference, mesh.corners(mesh.triangles[i]));
  }
  std::vector<MeshPiece> out;
  for (const PieceSums& piece : sums) out.push_back(piece.piece(reference));
  if (count > 1) mark_enclosed(mesh, piece_of, sums, out);
  return out;
}

void sort_by_volume(std::vector<MeshPiece>& pieces) {
  std::ranges::stable_sort(pieces, [](const MeshPiece& a, const MeshPiece& b) { return a.volume_mm3 > b.volume_mm3; });
}

}  // namespace

std::vector<MeshPiece> pieces_of(const TriangleMesh& mesh) {
  std::vector<MeshPiece> out = pieces_in_order(mesh, components_of(mesh));
  sort_by_volume(out);
  return out;
}

std::vector<MeshPiece> turn_outwards(TriangleMesh& mesh, bool all) {
  const std::vector<std::size_t> piece_of = components_of(mesh);
  std::vector<MeshPiece> out = pieces_in_order(mesh, piece_of);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const MeshPiece& piece = out[piece_of[i]];
    if (piece.faces_inwards && (all || !piece.inside_another)) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
  }
  sort_by_volume(out);
  return out;
}

double outer_volume_mm3(const std::vector<MeshPiece>& pieces) {
  double sum = 0;
  for (const MeshPiece& piece : pieces) sum += piece.inside_another ? 0 : piece.volume_mm3;
  return sum;
}

std::vector<std::string> warnings_of(const std::vector<MeshPiece>& pieces) {
  std::vector<std::string> out;
  std::vector<MeshPiece> outer = chosen(pieces, [](const MeshPiece& piece) { return !piece.inside_another; });
  const std::size_t inside = pieces.size() - outer.size();
  const auto inward = chosen(outer, [](const MeshPiece& piece) { return piece.faces_inwards; });
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
