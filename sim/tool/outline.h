#pragma once

#include <vector>

#include "sim/tool/profile.h"

namespace reamsim {

/// A line or an arc of at most 100° in (r, z) of the tool frame T, mm, the inside on its left.
struct OutlineArc {
  Vec2 begin, end;
  Vec2 along_begin, along_end;  ///< unit tangents
  Vec2 middle;                  ///< the point half way
  Vec2 normal;                  ///< outward unit normal there
  double curvature = 0;         ///< 1/mm, positive where it bulges outwards; 0 for a line

  [[nodiscard]] double length() const;
  /// Distance of a point from it, mm.
  [[nodiscard]] double distance(const Vec2& rz) const;
};

/// The tool's profile as lines and arcs: what its vertices lie on.
struct Outline {
  std::vector<OutlineArc> arcs;  ///< in order; edges on the spin axis are not among them
  double bulge_mm = 0;           ///< furthest that an arc lies from the profile's edges
};

/// By how much an outline turns at a vertex, rad; one that turns by more has a sharp corner there.
inline constexpr double kSharpTurn = 0.2;
/// Vertices as near to a circle lie on it, mm.
inline constexpr double kOnArcMm = 5e-4;

/// By how much an outline turns from direction `a` to `b`, rad; positive to the left.
double turn_between(const Vec2& a, const Vec2& b);

/// Four or more vertices in a row that lie within kOnArcMm of a circle, and between which the profile nowhere turns by
/// more than kSharpTurn, become an arc through them; every other edge is a line.
Outline fit_outline(const Profile& profile);

}  // namespace reamsim
