#pragma once

#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

/// Area of a closed polygon, mm²; positive when it runs counter-clockwise.
double signed_area(const std::vector<Vec2>& polygon);

/// The closed polygon with fewer points, none of the dropped ones farther than `tolerance_mm` from it (Douglas and
/// Peucker 1973). Starts at the lowest point, the innermost of several.
std::vector<Vec2> simplify(const std::vector<Vec2>& polygon, double tolerance_mm);

/// Replaces edges that cut a corner of a traced outline (no longer than a lattice cell's diagonal, between two edges of
/// at least three steps) by the corner itself. Corners move by less than `step_mm`.
std::vector<Vec2> sharpen_corners(const std::vector<Vec2>& polygon, double step_mm);

}  // namespace reamsim
