// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "sim/base/geometry.h"

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

}  // namespace reamsim
