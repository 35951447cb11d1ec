// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "sim/base/geometry.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// A line or an arc of at most 100° in (r, z) of the tool frame T, mm, the inside on its left.
struct OutlineArc {
  Vec2 begin, end;
  Vec2 along_begin, along_end;  ///< unit tangents
  Vec2 middle;                  ///< point at half length
  Vec2 normal;                  ///< outward unit normal there
  double curvature = 0;         ///< 1/mm, positive where it bulges outwards; 0 for a line

  [[nodiscard]] double length() const;
  /// Distance of a point from it, mm.
  [[nodiscard]] double distance(const Vec2& rz) const;
};

/// Lines and arcs through the vertices of a tool's profile.
struct Outline {
  std::vector<OutlineArc> arcs;  ///< in order, without edges on the spin axis
  double bulge_mm = 0;           ///< largest distance of an arc from the profile's edges
};

/// An outline has a sharp corner where its direction changes by more, rad.
inline constexpr double kSharpTurn = 0.2;
/// Tolerance of vertices on a circle, mm.
inline constexpr double kOnArcMm = 5e-4;

/// The angle from direction `a` to `b`, rad; positive to the left.
double angle_between(const Vec2& a, const Vec2& b);

/// Fits arcs to four or more vertices within kOnArcMm of a circle and without sharp corners; other edges are lines.
Outline fit_outline(const Profile& profile);

/// Area of a closed polygon, mm²; positive if counter-clockwise.
double signed_area(const std::vector<Vec2>& polygon);

/// Simplifies a closed polygon: dropped points lie within `tolerance_mm` of the result (Douglas and Peucker 1973). It
/// begins at the lowest point, the innermost of several.
std::vector<Vec2> simplify(const std::vector<Vec2>& polygon, double tolerance_mm);

/// Restores corners of a traced outline: replaces an edge that cuts off a corner (no longer than a lattice cell's
/// diagonal, between edges of at least three steps) by the corner. Corners move by less than `step_mm`.
std::vector<Vec2> sharpen_corners(const std::vector<Vec2>& polygon, double step_mm);

}  // namespace reamsim
