// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>

#include "sim/mesh/triangle_mesh.h"

namespace reamsim::test {

/// An end mill as plain as can be, T: a prism from z = 0 to `height` whose section reaches to `outer` over half of
/// every tooth's pitch, and to `inner` over the other half. Facing outwards.
inline TriangleMesh gear_mesh(int teeth, double inner, double outer, double height) {
  constexpr int kArc = 12;  // edges of half a pitch
  const int rim = 2 * teeth * (kArc + 1);
  TriangleMesh mesh;
  const auto corner = [&](int i, double z) -> Vec3 {
    const int half = i / (kArc + 1);
    const double angle = M_PI / teeth * (half + double(i % (kArc + 1)) / kArc), r = half % 2 == 0 ? outer : inner;
    return {r * std::cos(angle), r * std::sin(angle), z};
  };
  for (const double z : {0.0, height}) {
    for (int i = 0; i < rim; ++i) mesh.vertices.push_back(corner(i, z));
  }
  mesh.vertices.emplace_back(0, 0, 0);
  mesh.vertices.emplace_back(0, 0, height);
  for (int i = 0; i < rim; ++i) {
    const int next = (i + 1) % rim;
    mesh.triangles.push_back({i, next, next + rim});
    mesh.triangles.push_back({i, next + rim, i + rim});
    mesh.triangles.push_back({2 * rim, next, i});
    mesh.triangles.push_back({2 * rim + 1, i + rim, next + rim});
  }
  return mesh;
}

}  // namespace reamsim::test
