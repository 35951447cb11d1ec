// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "assets/reamer_shapes.h"
#include "sim/mesh/mesh_io.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/real_data.h"

// Straight plunges of shipped reamers into bones given as meshes, and what the reamer's face sweeps as a mesh.
namespace reamsim::test {

struct Plunge {
  std::string name, reamer;
  double curvature_mm = 0, radius_mm = 0;  ///< of the spherical face (0: flat); of the rim
  TriangleMesh bone;                       ///< mm
  Vec3 entry_mm, axis;
  double depth_mm = 0;
};

/// Vertices of a circle, and edges of the face in (r, z): facets within 0.6 µm of the surface.
inline constexpr int kRing = 360, kFaceEdges = 120;
/// The sweep reaches this far above the rim: beyond all bone there.
inline constexpr double kSweepTop_mm = 12;

/// The factor by which a regular polygon's vertices lie outside a circle of the same area. `step`: angle of a side.
inline double equal_area_factor(double step) {
  return std::sqrt(step / std::sin(step));
}

/// The closed polygon (r, z) turned about z. Counter-clockwise in (r, z), r to the right, faces outwards.
inline TriangleMesh revolved(const std::vector<Vec2>& polygon) {
  TriangleMesh mesh;
  const double step = 2 * std::numbers::pi / kRing;
  const auto points = static_cast<int>(polygon.size());
  for (const Vec2& p : polygon) {
    for (int i = 0; i < kRing; ++i) {
      const double r = equal_area_factor(step) * p.x();
      mesh.vertices.emplace_back(r * std::cos(step * i), r * std::sin(step * i), p.y());
    }
  }
  for (int k = 0; k < points; ++k) {
    for (int i = 0; i < kRing; ++i) {
      const int next = (k + 1) % points * kRing, j = (i + 1) % kRing;
      mesh.triangles.push_back({k * kRing + i, k * kRing + j, next + j});
      mesh.triangles.push_back({k * kRing + i, next + j, next + i});
    }
  }
  return mesh;
}

/// What the face of the reamer sweeps on its way to full depth, in the bone frame.
inline TriangleMesh swept(const Plunge& plunge) {
  const double inner = assets::kCannulaRadiusMm, outer = plunge.radius_mm, curvature = plunge.curvature_mm;
  std::vector<Vec2> polygon{{inner, 0}, {outer, 0}};
  if (curvature > 0) {
    polygon.clear();
    const double first = std::asin(inner / curvature), step = (std::asin(outer / curvature) - first) / kFaceEdges;
    const double radius = curvature * equal_area_factor(step);
    for (int i = 0; i <= kFaceEdges; ++i) {
      polygon.emplace_back(radius * std::sin(first + step * i), curvature - radius * std::cos(first + step * i));
    }
  }
  const double top = polygon.back().y() + kSweepTop_mm;
  polygon.insert(polygon.end(), {{polygon.back().x(), top}, {polygon.front().x(), top}});
  TriangleMesh mesh = revolved(polygon);
  const Vec3 axis = plunge.axis.normalized();
  const Quat turn = Quat::FromTwoVectors(-Vec3::UnitZ(), axis);
  for (Vec3& v : mesh.vertices) v = turn * v + plunge.entry_mm + plunge.depth_mm * axis;
  return mesh;
}

// Faces and axes are oblique to the lattice, or beside its planes.

inline Plunge ball_into_box() {
  return {"hemispherical reamer into a box",
          "hemispherical",
          assets::kHemisphereRadiusMm,
          assets::kHemisphereRadiusMm,
          box_mesh({-13.1, -12.9, -6.03}, {13.3, 13.2, 0.04}),
          {0.31, -0.23, 0},
          {0.11, -0.07, -1},
          4.1};
}

inline Plunge flat_into_sphere() {
  return {"flat reamer into a sphere of 20 mm radius",
          "flat",
          0,
          assets::kFlatRadiusMm,
          sphere_mesh({0.13, -0.08, -20.05}, 20, 6),
          {0.4, 0.2, 0},
          {-0.09, 0.05, -1},
          3.1};
}

inline const std::string kScapula = "scapula_mesh/scapula_left.stl";

/// As trajectories/mesh_scapula.yaml; needs its mesh in REAMSIM_DATA.
inline Plunge convex_into_scapula() {
  return {"convex reamer into a scapula",     "convex",           assets::kConvexCurvatureMm, assets::kConvexRadiusMm,
          read_mesh(data_file(kScapula), 55), {-41.2, 9.2, 36.6}, {0.93, -0.355, 0.08},       4.1};
}

}  // namespace reamsim::test
