// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "sim/tool/envelope.h"

namespace reamsim {

namespace {

/// Tolerance of (r, z) in a ring; 32-bit STL coordinates of a reamer have an error below 1 µm.
constexpr double kRingMm = 2e-3;
/// Tolerated sagitta of a facet.
constexpr double kSagittaMm = 0.02;
/// Tolerated relative difference between the volumes of mesh and revolved polygon; detects partial revolutions.
constexpr double kVolumeTolerance = 0.01;

using Cell = std::pair<long, long>;

double radius_of(const Vec3& p) {
  return std::hypot(p.x(), p.y());
}

/// Groups vertices by (r, z): the ring of each vertex, and each ring's mean position.
class Rings {
 public:
  explicit Rings(const TriangleMesh& mesh) {
    for (const Vec3& p : mesh.vertices) ring_of_.push_back(find_or_add({radius_of(p), p.z()}));
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      Vec2 mean = sums_[i] / counts_[i];
      if (mean.x() < kRingMm) mean.x() = 0;
      means_.push_back(mean);
    }
  }

  [[nodiscard]] std::size_t of(std::int32_t vertex) const { return ring_of_[static_cast<std::size_t>(vertex)]; }
  [[nodiscard]] const std::vector<Vec2>& means() const { return means_; }

 private:
  std::size_t find_or_add(const Vec2& rz) {
    const long i = std::lround(rz.x() / kRingMm), j = std::lround(rz.y() / kRingMm);
    for (long di = -1; di <= 1; ++di)
      for (long dj = -1; dj <= 1; ++dj) {
        const auto [first, last] = first_in_cell_.equal_range({i + di, j + dj});
        for (auto it = first; it != last; ++it)
          if ((firsts_[it->second] - rz).norm() <= kRingMm) return add_to(it->second, rz);
      }
    firsts_.push_back(rz);
    sums_.push_back(Vec2::Zero());
    counts_.push_back(0);
    first_in_cell_.emplace(Cell{i, j}, firsts_.size() - 1);
    return add_to(firsts_.size() - 1, rz);
  }

  std::size_t add_to(std::size_t ring, const Vec2& rz) {
    sums_[ring] += rz;
    counts_[ring] += 1;
    return ring;
  }

  std::vector<std::size_t> ring_of_;
  std::vector<Vec2> firsts_, sums_, means_;
  std::vector<double> counts_;
  std::multimap<Cell, std::size_t> first_in_cell_;
};

using Links = std::vector<std::vector<std::size_t>>;

bool link(Links& links, std::size_t a, std::size_t b) {
  if (a == b) return true;
  if (std::find(links[a].begin(), links[a].end(), b) != links[a].end()) return true;
  links[a].push_back(b);
  links[b].push_back(a);
  return links[a].size() <= 2 && links[b].size() <= 2;
}

/// Whether an edge lies within kSagittaMm of the surface of revolution through its ends.
bool edge_is_fine(const Vec3& a, const Vec3& b) {
  return 0.5 * (radius_of(a) + radius_of(b)) - radius_of(0.5 * (a + b)) <= kSagittaMm;
}

/// The rings that triangles connect; nullopt when a triangle spans three rings or is too coarse, or a ring branches.
std::optional<Links> link_rings(const TriangleMesh& mesh, const Rings& rings) {
  Links links(rings.means().size());
  for (const auto& t : mesh.triangles) {
    const std::size_t a = rings.of(t[0]), b = rings.of(t[1]), c = rings.of(t[2]);
    if (a != b && b != c && c != a) return std::nullopt;
    if (!link(links, a, b) || !link(links, b, c) || !link(links, c, a)) return std::nullopt;
    for (std::size_t k = 0; k < 3; ++k)
      if (!edge_is_fine(mesh.vertices[static_cast<std::size_t>(t[k])],
                        mesh.vertices[static_cast<std::size_t>(t[(k + 1) % 3])]))
        return std::nullopt;
  }
  return links;
}

/// The rings in order, from an end on the axis or anywhere on a closed chain; nullopt unless the chain has all rings.
std::optional<std::vector<std::size_t>> walk(const Links& links, const std::vector<Vec2>& means) {
  std::size_t start = 0, ends = 0;
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (links[i].size() == 2) continue;
    if (links[i].size() != 1 || !Profile::on_axis(means[i])) return std::nullopt;
    start = i;
    ++ends;
  }
  if (ends != 0 && ends != 2) return std::nullopt;
  std::vector<std::size_t> order{start};
  for (std::size_t previous = start, here = links[start][0]; here != start;) {
    order.push_back(here);
    if (links[here].size() == 1) break;
    const std::size_t next = links[here][0] == previous ? links[here][1] : links[here][0];
    previous = std::exchange(here, next);
  }
  if (order.size() != links.size()) return std::nullopt;
  return order;
}

}  // namespace

std::optional<Profile> recover_generatrix(const TriangleMesh& mesh) {
  const Rings rings(mesh);
  if (rings.means().size() < 3) return std::nullopt;
  const auto links = link_rings(mesh, rings);
  if (!links) return std::nullopt;
  const auto order = walk(*links, rings.means());
  if (!order) return std::nullopt;
  Profile profile;
  for (const std::size_t ring : *order) profile.points.push_back(rings.means()[ring]);
  if (profile.volume_mm3() < 0) std::reverse(profile.points.begin(), profile.points.end());
  if (std::abs(profile.volume_mm3() - mesh.volume_mm3()) > kVolumeTolerance * profile.volume_mm3()) return std::nullopt;
  return profile;
}

}  // namespace reamsim
