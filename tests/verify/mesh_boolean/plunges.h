// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "sim/mesh/mesh_io.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/real_data.h"
#include "tests/tool/reamer_files.h"

// Straight plunges of shipped reamers into bones given as meshes, and what they sweep as a mesh.
namespace reamsim::test {

struct Plunge {
  std::string name, reamer;
  TriangleMesh bone;  ///< mm
  Vec3 entry_mm, axis;
  double depth_mm = 0;
};

/// Rings of a circle; a facet's chord is 0.15 µm off a circle of 15 mm.
inline constexpr int kRing = 720;
/// What the sweep reaches above the tool's rim: more than any bone there.
inline constexpr double kSweepTop_mm = 12;

/// The closed polygon (r, z) turned about z, rings of equal area as the circles. Counter-clockwise in (r, z) faces outwards.
inline TriangleMesh revolved(const std::vector<Vec2>& polygon) {
  TriangleMesh mesh;
  const double step = 2 * std::numbers::pi / kRing, radius_factor = std::sqrt(step / std::sin(step));
  const auto points = static_cast<int>(polygon.size());
  for (const Vec2& p : polygon) {
    for (int i = 0; i < kRing; ++i) {
      const double r = radius_factor * p.x();
      mesh.vertices.emplace_back(r * std::cos(step * i), r * std::sin(step * i), p.y());
    }
  }
  for (int k = 0; k < points; ++k) {
    for (int i = 0; i < kRing; ++i) {
      const int a = k * kRing + i, b = k * kRing + (i + 1) % kRing;
      const int c = (k + 1) % points * kRing + i, d = (k + 1) % points * kRing + (i + 1) % kRing;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
  return mesh;
}

/// The lower outline (r, z) of a reamer with a convex face, from its cannula to its rim: the lower convex hull of the rings
/// of its mesh.
inline std::vector<Vec2> face_outline(const TriangleMesh& reamer) {
  std::map<double, double> lowest;  // z by r; rings in single precision
  for (const Vec3& v : reamer.vertices) {
    const double r = std::round(1e4 * radius_of(v)) / 1e4;
    const auto [at, is_new] = lowest.try_emplace(r, v.z());
    if (!is_new) at->second = std::min(at->second, v.z());
  }
  std::vector<Vec2> hull;
  for (const auto& [r, z] : lowest) {
    const Vec2 p(r, z);
    const auto turns_right = [&](const Vec2& a, const Vec2& b) {
      return (b - a).x() * (p - a).y() - (b - a).y() * (p - a).x() <= 0;
    };
    while (hull.size() > 1 && turns_right(hull[hull.size() - 2], hull.back())) hull.pop_back();
    hull.push_back(p);
  }
  return hull;
}

/// What the face of the reamer sweeps on its way to full depth, in the bone frame.
inline TriangleMesh swept(const Plunge& plunge) {
  std::vector<Vec2> polygon = face_outline(reamer(plunge.reamer));
  const double top = polygon.back().y() + kSweepTop_mm, inner = polygon.front().x();
  polygon.emplace_back(polygon.back().x(), top);
  polygon.emplace_back(inner, top);
  TriangleMesh mesh = revolved(polygon);
  const Vec3 axis = plunge.axis.normalized();
  const Quat turn = Quat::FromTwoVectors(-Vec3::UnitZ(), axis);
  for (Vec3& v : mesh.vertices) v = turn * v + plunge.entry_mm + plunge.depth_mm * axis;
  return mesh;
}

/// A ball into a box, oblique to both lattices.
inline Plunge ball_into_box() {
  return {"hemispherical reamer into a box", "hemispherical", box_mesh({-18.1, -17.9, -8.03}, {18.3, 18.2, 0.04}),
          {0.31, -0.23, 0}, {0.11, -0.07, -1}, 4.1};
}

inline Plunge flat_into_sphere() {
  return {"flat reamer into a sphere of 20 mm radius", "flat", sphere_mesh({0.13, -0.08, -20.05}, 20, 6),
          {0.4, 0.2, 0}, {-0.09, 0.05, -1}, 3.1};
}

/// As trajectories/mesh_scapula.yaml; needs its mesh in REAMSIM_DATA.
inline Plunge convex_into_scapula() {
  return {"convex reamer into the scapula", "convex", read_mesh(data_file("scapula_mesh/scapula_left.stl"), 55),
          {-41.2, 9.2, 36.6}, {0.93, -0.355, 0.08}, 4.1};
}

}  // namespace reamsim::test
