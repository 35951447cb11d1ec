// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Triangles are cut at the faces of the voxels. The part of the solid below a piece is a prism within the voxel of the
// piece, and the same share of every voxel below it: counted with the sign of the normal's z, these add up to the
// solid.
#include "sim/bone/mesh_fractions.h"

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <cmath>

#include "sim/base/parallel.h"

namespace reamsim {
namespace {

using Polygon = boost::container::small_vector<Vec3, 10>;  // a triangle cut by the faces of a cube has up to 9 corners

/// The parts of a convex polygon below and above a plane.
std::pair<Polygon, Polygon> split(const Polygon& polygon, int axis, double at) {
  std::pair<Polygon, Polygon> out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if (a[axis] <= at) out.first.push_back(a);
    if (a[axis] >= at) out.second.push_back(a);
    if ((a[axis] - at) * (b[axis] - at) >= 0) continue;
    Vec3 between = a + (at - a[axis]) / (b[axis] - a[axis]) * (b - a);
    between[axis] = at;
    out.first.push_back(between);
    out.second.push_back(between);
  }
  return out;
}

/// Calls visit(n, part) for the parts of a polygon with n <= coordinate <= n + 1, n from `first` to `last`.
template <class Visit>
void for_each_slab(Polygon polygon, int axis, int first, int last, const Visit& visit) {
  const auto [low, high] = std::ranges::minmax(polygon, {}, [axis](const Vec3& p) { return p[axis]; });
  const int begin = std::max(first, static_cast<int>(std::floor(low[axis])));
  const int end = std::min(last, static_cast<int>(std::floor(high[axis])));
  if (begin > low[axis]) polygon = split(polygon, axis, begin).second;
  for (int n = begin; n <= end && polygon.size() > 2; ++n) {
    const auto [part, rest] = split(polygon, axis, n + 1);
    if (part.size() > 2) visit(n, part);
    polygon = rest;
  }
}

/// The projection of a polygon along z and the prism between it and z = `base`; negative where it faces down.
struct Prism {
  double area = 0, volume = 0;

  Prism(const Polygon& polygon, double base) {
    for (std::size_t i = 2; i < polygon.size(); ++i) {
      const Vec3 &a = polygon[0], &b = polygon[i - 1], &c = polygon[i];
      const double part = 0.5 * (b - a).cross(c - a).z();
      area += part;
      volume += part * ((a.z() + b.z() + c.z()) / 3 - base);
    }
  }
};

}  // namespace

MeshFractions::MeshFractions(const TriangleMesh& mesh, const VoxelGrid& grid)
    : dims_(grid.dims), layers_(static_cast<std::size_t>(grid.dims.x())) {
  std::vector<std::vector<std::array<Vec3, 3>>> triangles(layers_.size());
  for (const MeshTriangle& triangle : mesh.triangles) {
    std::array<Vec3, 3> corners = mesh.corners(triangle);
    for (Vec3& corner : corners) corner = (corner - grid.origin_mm) / grid.voxel_mm;
    const auto [low, high] = std::minmax({corners[0].x(), corners[1].x(), corners[2].x()});
    const int last = std::min(dims_.x() - 1, static_cast<int>(std::floor(high)));
    for (int x = std::max(0, static_cast<int>(std::floor(low))); x <= last; ++x) {
      triangles[static_cast<std::size_t>(x)].push_back(corners);
    }
  }
  parallel_items(layers_.size(),
                 [&](std::size_t x) { layers_[x] = fractions_in_layer(static_cast<int>(x), triangles[x]); });
}

std::vector<MeshFractions::Fraction> MeshFractions::fractions_in_layer(
    int x, const std::vector<std::array<Vec3, 3>>& triangles) const {
  std::vector<std::pair<std::int64_t, Prism>> prisms;
  for (const auto& [a, b, c] : triangles) {
    for_each_slab({a, b, c}, 0, x, x, [&](int, const Polygon& in_layer) {
      for_each_slab(in_layer, 1, 0, dims_.y() - 1, [&](int y, const Polygon& in_column) {
        for_each_slab(in_column, 2, 0, dims_.z() - 1,
                      [&](int z, const Polygon& piece) { prisms.emplace_back(key(y, z), Prism(piece, z)); });
      });
    });
  }
  std::ranges::stable_sort(prisms, {}, [](const auto& prism) { return prism.first; });
  std::vector<Fraction> out;
  double above = 0;  // area of the pieces in voxels above
  for (std::size_t i = 0; i < prisms.size();) {
    const std::int64_t voxel = prisms[i].first;
    if (out.empty() || out.back().first / dims_.z() != voxel / dims_.z()) above = 0;
    double fraction = above;
    for (; i < prisms.size() && prisms[i].first == voxel; ++i) {
      fraction += prisms[i].second.volume;
      above += prisms[i].second.area;
    }
    out.emplace_back(voxel, static_cast<float>(fraction));
  }
  return out;
}

std::optional<double> MeshFractions::at(const Vec3i& voxel) const {
  const std::vector<Fraction>& layer = layers_[static_cast<std::size_t>(voxel.x())];
  const std::int64_t wanted = key(voxel.y(), voxel.z());
  const auto found = std::ranges::lower_bound(layer, wanted, {}, &Fraction::first);
  if (found == layer.end() || found->first != wanted) return std::nullopt;
  return double{found->second};
}

}  // namespace reamsim
