// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_repair.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "sim/mesh/mesh_check.h"
#include "sim/mesh/winding.h"

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

}  // namespace

std::vector<MeshPiece> turn_outwards(TriangleMesh& mesh, bool all) {
  const std::vector<std::size_t> piece_of = components_of(mesh);
  const std::size_t count = piece_of.empty() ? 0 : 1 + *std::ranges::max_element(piece_of);
  const Vec3 reference = mesh.bounds().center();
  std::vector<PieceSums> sums(count);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    sums[piece_of[i]].add(reference, mesh.corners(mesh.triangles[i]));
  }
  std::vector<MeshPiece> out;
  for (const PieceSums& piece : sums) out.push_back(piece.piece(reference));
  if (count > 1) mark_enclosed(mesh, piece_of, sums, out);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const MeshPiece& piece = out[piece_of[i]];
    if (piece.faces_inwards && (all || !piece.inside_another)) std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
  }
  std::ranges::stable_sort(out, std::greater(), &MeshPiece::volume_mm3);
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
