// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "render/pictures/local_fit.h"
#include "render/pictures/scale.h"

namespace reamsim {

/// A closed line on which a field has one value; the field is greater on its left.
struct ContourLine {
  double value = 0;
  std::vector<Vec2> points_mm;  ///< evenly spaced

  [[nodiscard]] double length_mm() const;
};

/// All lines of one value: marching squares, then smoothed along the line, against the steps of the raster. The raster
/// counts as surrounded by lower values, so that every line is closed.
std::vector<ContourLine> contour_lines(const RasterField& field, double value);

/// The lines at the ticks of a legend above 0, ascending, as every picture of reamed depth draws them. Rings shorter
/// than kShortestContour_mm, such as those around the core of a cannula, are left out.
std::vector<ContourLine> depth_contours(const RasterField& signed_depth_mm, const Scale& scale);
constexpr double kShortestContour_mm = 12;

}  // namespace reamsim
