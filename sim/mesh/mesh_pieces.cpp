// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_pieces.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "sim/mesh/mesh_check.h"

namespace reamsim {

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
    return {std::abs(volume_mm3), centre, false};
  }
};

/// A point, and whether the ray along +z from it crosses the other pieces an odd number of times.
struct Probe {
  Vec3 point;
  std::size_t piece;
  bool odd = false;
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

/// Counts the triangles above each probe: one pass over the triangles, with the probes sorted by x.
void count_crossings(const TriangleMesh& mesh, const std::vector<std::size_t>& piece_of, std::vector<Probe>& probes) {
  std::ranges::sort(probes, {}, [](const Probe& probe) { return probe.point.x(); });
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(mesh.triangles[i]);
    const auto [least, most] = std::minmax({a.x(), b.x(), c.x()});
    auto probe = std::ranges::lower_bound(probes, least, {}, [](const Probe& p) { return p.point.x(); });
    for (; probe != probes.end() && probe->point.x() <= most; ++probe) {
      if (probe->piece != piece_of[i] && is_below(probe->point, {a, b, c})) probe->odd = !probe->odd;
    }
  }
}

/// A piece is inside another if its outermost vertices are.
void mark_enclosed(const TriangleMesh& mesh, const std::vector<std::size_t>& piece_of,
                   const std::vector<PieceSums>& sums, std::vector<MeshPiece>& pieces) {
  std::vector<Probe> probes;
  for (std::size_t n = 0; n < sums.size(); ++n) {
    for (const Vec3& point : sums[n].extreme_mm) probes.push_back({point, n});
    pieces[n].inside_another = true;
  }
  count_crossings(mesh, piece_of, probes);
  for (const Probe& probe : probes) pieces[probe.piece].inside_another &= probe.odd;
}

std::string place_of(const MeshPiece& piece) {
  const Vec3& c = piece.centre_mm;
  return fmt::format("{:.{}f} mm3 at ({:.1f}, {:.1f}, {:.1f}) mm", piece.volume_mm3, piece.volume_mm3 < 10 ? 2 : 0,
                     c.x(), c.y(), c.z());
}

}  // namespace

std::vector<MeshPiece> pieces_of(const TriangleMesh& mesh) {
  const std::vector<std::size_t> piece_of = components_of(mesh);
  const std::size_t count = piece_of.empty() ? 0 : 1 + *std::ranges::max_element(piece_of);
  const Aabb box = mesh.bounds();
  const Vec3 reference = 0.5 * (box.min + box.max);
  std::vector<PieceSums> sums(count);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(mesh.triangles[i]);
    sums[piece_of[i]].add(reference, {a, b, c});
  }
  std::vector<MeshPiece> out;
  for (const PieceSums& piece : sums) out.push_back(piece.piece(reference));
  if (count > 1) mark_enclosed(mesh, piece_of, sums, out);
  std::ranges::stable_sort(out, [](const MeshPiece& a, const MeshPiece& b) { return a.volume_mm3 > b.volume_mm3; });
  return out;
}

std::vector<std::string> warnings_of(const std::vector<MeshPiece>& pieces) {
  constexpr std::ptrdiff_t kMostNamed = 3;
  std::vector<std::string> out;
  std::string places;
  std::ptrdiff_t outside = 0, inside = 0;
  for (std::size_t n = 1; n < pieces.size(); ++n) {
    if (pieces[n].inside_another) {
      ++inside;
    } else if (++outside <= kMostNamed) {
      places += (outside == 1 ? "" : ", ") + place_of(pieces[n]);
    }
  }
  if (outside > kMostNamed) places += fmt::format(" and {} more", outside - kMostNamed);
  if (outside > 0) {
    out.push_back(
        fmt::format("the mesh has {} besides the largest: {}; all are kept as bone: remove in the mesh what is no bone",
                    outside == 1 ? "a piece" : fmt::format("{} pieces", outside), places));
  }
  if (inside > 0) {
    out.push_back(fmt::format("the mesh has {} inside another; a surface inside another does not create a cavity",
                              inside == 1 ? "a surface" : fmt::format("{} surfaces", inside)));
  }
  return out;
}

}  // namespace reamsim
