// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "sim/base/geometry.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// A point with a smaller radius counts as on the spin axis, mm.
inline constexpr double kOnAxisMm = 1e-6;
/// At a smaller distance the normal is the edge's instead of the direction to the surface, mm.
inline constexpr double kOnSurfaceMm = 1e-9;

/// The tool's envelope of revolution: a closed polygon in (r, z) of the tool frame T, r ≥ 0, mm, counter-clockwise (r
/// right, z up), with the inside on the left. Edges on the axis r = 0 are not surface.
struct Profile {
  std::vector<Vec2> points;

  [[nodiscard]] static bool on_axis(const Vec2& rz) { return rz.x() < kOnAxisMm; }
  /// Largest r, mm.
  [[nodiscard]] double max_radius_mm() const;
  /// The box of the solid of revolution, T, mm.
  [[nodiscard]] Aabb bounds() const;
  /// Signed distance to the surface (negative inside), and outward unit normal (n_r, n_z) at the nearest point, from
  /// all edges. The reference for the device code.
  struct Nearest {
    double distance_mm;
    Vec2 normal;
  };
  [[nodiscard]] Nearest nearest(const Vec2& rz) const;
  /// Volume of the solid of revolution, mm³ (Pappus).
  [[nodiscard]] double volume_mm3() const;
};

/// Revolves a profile about z to a closed mesh (mm, frame T) with `segments` vertices per ring, the first at angle 0.
/// Vertices lie on the surface of revolution, and facets within r·(1 − cos(π/segments)) of it. A profile point on the
/// axis becomes one vertex; an edge on the axis yields no triangle.
TriangleMesh revolve(const Profile& profile, int segments);

/// Vertices per ring for a sagitta of at most `sagitta_mm` at `radius_mm`; at least 32, a multiple of 4.
int segments_for_sagitta(double radius_mm, double sagitta_mm);

}  // namespace reamsim
