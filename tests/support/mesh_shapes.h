// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <map>
#include <utility>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim::test {

/// A box of 12 triangles, facing outwards.
inline TriangleMesh box_mesh(const Vec3& min, const Vec3& max) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1) ? max.x() : min.x(), (i & 2) ? max.y() : min.y(), (i & 4) ? max.z() : min.z());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// An icosahedron whose triangles were split `splits` times and put onto the sphere; 20·4^splits triangles.
inline TriangleMesh sphere_mesh(const Vec3& center, double radius, int splits) {
  TriangleMesh mesh;
  const double g = (1 + std::sqrt(5.0)) / 2;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-g, g}) {
      mesh.vertices.emplace_back(0, a, b);
      mesh.vertices.emplace_back(a, b, 0);
      mesh.vertices.emplace_back(b, 0, a);
    }
  }
  const auto n = static_cast<std::int32_t>(mesh.vertices.size());
  for (std::int32_t i = 0; i < n; ++i) {
    for (std::int32_t j = i + 1; j < n; ++j) {
      for (std::int32_t k = j + 1; k < n; ++k) {  // corners whose distance is an edge's: 2
        const Vec3 a = mesh.vertices[static_cast<std::size_t>(i)];
        const Vec3 b = mesh.vertices[static_cast<std::size_t>(j)];
        const Vec3 c = mesh.vertices[static_cast<std::size_t>(k)];
        if ((a - b).norm() > 2.01 || (b - c).norm() > 2.01 || (c - a).norm() > 2.01) continue;
        if (a.dot(b.cross(c)) > 0) {
          mesh.triangles.push_back({i, j, k});
        } else {
          mesh.triangles.push_back({i, k, j});
        }
      }
    }
  }
  for (int split = 0; split < splits; ++split) {
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
    const auto middle = [&](std::int32_t a, std::int32_t b) {
      const auto [found, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::int32_t>(mesh.vertices.size()));
      if (is_new) {
        mesh.vertices.push_back(0.5 * (mesh.vertices[static_cast<std::size_t>(a)].normalized() +
                                       mesh.vertices[static_cast<std::size_t>(b)].normalized()));
      }
      return found->second;
    };
    std::vector<std::array<std::int32_t, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::int32_t ab = middle(a, b);
      const std::int32_t bc = middle(b, c);
      const std::int32_t ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (Vec3& vertex : mesh.vertices) vertex = center + radius * vertex.normalized();
  return mesh;
}

/// The same surface with its triangles facing the other way.
inline TriangleMesh joined(const std::vector<TriangleMesh>& parts) {
  TriangleMesh out;
  for (const TriangleMesh& part : parts) {
    const auto before = static_cast<std::int32_t>(out.vertices.size());
    out.vertices.insert(out.vertices.end(), part.vertices.begin(), part.vertices.end());
    for (const auto& [a, b, c] : part.triangles) out.triangles.push_back({a + before, b + before, c + before});
  }
  return out;
}

inline TriangleMesh inside_out(TriangleMesh mesh) {
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

}  // namespace reamsim::test
