// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

/// Area of a closed polygon, mm²; positive if counter-clockwise.
double signed_area(const std::vector<Vec2>& polygon);

/// Simplifies a closed polygon: dropped points lie within `tolerance_mm` of the result (Douglas and Peucker 1973). It
/// begins at the lowest point, the innermost of several.
std::vector<Vec2> simplify(const std::vector<Vec2>& polygon, double tolerance_mm);

/// Restores corners of a traced outline: replaces an edge that cuts off a corner (no longer than a lattice cell's
/// diagonal, between edges of at least three steps) by the corner. Corners move by less than `step_mm`.
std::vector<Vec2> sharpen_corners(const std::vector<Vec2>& polygon, double step_mm);

}  // namespace reamsim
