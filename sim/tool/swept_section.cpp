// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/swept_section.h"

#include <algorithm>
#include <cmath>

namespace reamsim {

namespace {

constexpr std::size_t kMaxSlabs = 256;
/// Limit of the slab table where every triangle spans the full height.
constexpr std::size_t kMaxSlabEntries = 50'000'000;

/// The point of edge a–b at height z, computed from the lower end so that both triangles of an edge agree.
Vec2 crossing(const Vec3& a, const Vec3& b, double z) {
  const Vec3& low = a.z() < b.z() ? a : b;
  const Vec3& high = a.z() < b.z() ? b : a;
  const double t = (z - low.z()) / (high.z() - low.z());
  return low.head<2>() + t * (high - low).head<2>();
}

SweptSection::Interval swept_radii(const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp(-a.dot(along) / length2, 0.0, 1.0) : 0.0;
  return {(a + t * along).norm(), std::max(a.norm(), b.norm())};
}

std::vector<SweptSection::Interval> merge(std::vector<SweptSection::Interval> intervals) {
  std::sort(intervals.begin(), intervals.end(), [](const auto& a, const auto& b) { return a.low < b.low; });
  std::vector<SweptSection::Interval> merged;
  for (const auto& i : intervals) {
    if (!merged.empty() && i.low <= merged.back().high)
      merged.back().high = std::max(merged.back().high, i.high);
    else
      merged.push_back(i);
  }
  return merged;
}

}  // namespace

SweptSection::SweptSection(const TriangleMesh& mesh) : mesh_(mesh) {
  const Aabb box = mesh.bounds();
  bottom_mm_ = box.min.z();
  const std::size_t triangles = std::max<std::size_t>(1, mesh.triangles.size());
  slabs_.resize(std::clamp<std::size_t>(kMaxSlabEntries / triangles, 1, kMaxSlabs));
  slab_mm_ = (box.max.z() - box.min.z()) / static_cast<double>(slabs_.size());
  const double top = static_cast<double>(slabs_.size()) - 1;
  const auto slab = [&](double z) {
    return static_cast<std::size_t>(std::clamp(std::floor((z - bottom_mm_) / slab_mm_), 0.0, top));
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto z = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][k])].z(); };
    const std::size_t last = slab(std::max({z(0), z(1), z(2)}));
    for (std::size_t s = slab(std::min({z(0), z(1), z(2)})); s <= last; ++s)
      slabs_[s].push_back(static_cast<std::int32_t>(t));
  }
}

std::vector<SweptSection::Piece> SweptSection::cut(double z_mm) const {
  std::vector<Piece> pieces;
  const double position = std::floor((z_mm - bottom_mm_) / slab_mm_);
  if (position < 0 || position > static_cast<double>(slabs_.size())) return pieces;
  for (const std::int32_t t : slabs_[std::min(static_cast<std::size_t>(position), slabs_.size() - 1)]) {
    const auto& triangle = mesh_.triangles[static_cast<std::size_t>(t)];
    const Vec3* v[3];
    bool above[3];
    for (std::size_t k = 0; k < 3; ++k) {
      v[k] = &mesh_.vertices[static_cast<std::size_t>(triangle[k])];
      above[k] = v[k]->z() >= z_mm;  // half open, so that a vertex at this height is consistent
    }
    Piece piece{Vec2::Zero(), Vec2::Zero()};
    bool crosses = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      if (above[k] == above[next]) continue;
      crosses = true;
      // Seen from outside, counter-clockwise: the section begins at a descending edge and ends at an ascending one.
      (above[k] ? piece.from : piece.to) = crossing(*v[k], *v[next], z_mm);
    }
    if (crosses) pieces.push_back(piece);
  }
  return pieces;
}

std::vector<SweptSection::Interval> SweptSection::at(double z_mm) const {
  const std::vector<Piece> pieces = cut(z_mm);
  std::vector<Interval> swept;
  for (const Piece& p : pieces) swept.push_back(swept_radii(p.from, p.to));
  swept = merge(std::move(swept));

  // Winding number of the section about (radius, 0), from the pieces that a ray along +x crosses.
  const auto inside = [&](double radius) {
    int winding = 0;
    for (const Piece& p : pieces) {
      if ((p.from.y() <= 0) == (p.to.y() <= 0)) continue;
      const double x = p.from.x() - p.from.y() * (p.to.x() - p.from.x()) / (p.to.y() - p.from.y());
      if (x > radius) winding += p.to.y() > p.from.y() ? 1 : -1;
    }
    return winding > 0;
  };
  std::vector<Interval> gaps;
  double low = 0;
  for (const Interval& i : swept) {
    if (i.low > low && inside(0.5 * (low + i.low))) gaps.push_back({low, i.low});
    low = i.high;
  }
  swept.insert(swept.end(), gaps.begin(), gaps.end());
  return merge(std::move(swept));
}

bool occupied(const std::vector<SweptSection::Interval>& intervals, double radius_mm) {
  return std::any_of(intervals.begin(), intervals.end(),
                     [&](const auto& i) { return radius_mm >= i.low && radius_mm <= i.high; });
}

}  // namespace reamsim
