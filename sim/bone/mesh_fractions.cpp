// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Triangles are cut at the faces of the voxels. Below a piece lies a prism in its own voxel, and its projected area
// times the edge length in each voxel below; negative where the piece faces down. The sum is the volume of the solid.
#include "sim/bone/mesh_fractions.h"

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <cmath>

#include "sim/base/parallel.h"

namespace reamsim {
namespace {

constexpr double kRounding = 1e-5;
constexpr float kTwice = 2;  // the fraction of a voxel in or above an overlap

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
  std::vector<std::vector<std::uint32_t>> triangles(layers_.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(mesh.triangles[i]);
    const auto [low_mm, high_mm] = std::minmax({a.x(), b.x(), c.x()});
    const auto layer = [&](double mm) {
      return static_cast<int>(std::floor((mm - grid.origin_mm.x()) / grid.voxel_mm));
    };
    const int last = std::min(dims_.x() - 1, layer(high_mm));
    for (int x = std::max(0, layer(low_mm)); x <= last; ++x) {
      triangles[static_cast<std::size_t>(x)].push_back(static_cast<std::uint32_t>(i));
    }
  }
  parallel_items(layers_.size(), [&](std::size_t x) {
    layers_[x] = fractions_in_layer(static_cast<int>(x), mesh, grid, triangles[x]);
  });
}

std::vector<MeshFractions::Fraction> MeshFractions::fractions_in_layer(
    int x, const TriangleMesh& mesh, const VoxelGrid& grid, const std::vector<std::uint32_t>& triangles) const {
  std::vector<std::pair<std::int64_t, Prism>> prisms;
  for (const std::uint32_t triangle : triangles) {
    Polygon polygon;
    for (const Vec3& corner : mesh.corners(mesh.triangles[triangle])) {
      polygon.push_back((corner - grid.origin_mm) / grid.voxel_mm);
    }
    for_each_slab(polygon, 0, x, x, [&](int, const Polygon& in_layer) {
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
    const bool twice = above > 1 + kRounding || above < -kRounding;
    out.emplace_back(voxel, twice ? kTwice : static_cast<float>(fraction));
  }
  return out;
}

bool MeshFractions::overlap() const {
  return std::ranges::any_of(layers_, [](const std::vector<Fraction>& layer) {
    return std::ranges::any_of(layer, [](const Fraction& voxel) { return voxel.second == kTwice; });
  });
}

std::optional<double> MeshFractions::at(const Vec3i& voxel) const {
  const std::vector<Fraction>& layer = layers_[static_cast<std::size_t>(voxel.x())];
  const std::int64_t wanted = key(voxel.y(), voxel.z());
  const auto found = std::ranges::lower_bound(layer, wanted, {}, &Fraction::first);
  if (found == layer.end() || found->first != wanted) return std::nullopt;
  return double{found->second};
}

}  // namespace reamsim
