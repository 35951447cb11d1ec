// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/pictures/page_layout.h"
#include "render/pictures/smoothed_mask.h"
#include "sim/base/geometry.h"

namespace reamsim {

/// A scalar on a raster of columns in the plane of a map.
struct RasterField {
  Raster raster;
  Vec2 corner_mm = Vec2::Zero();  ///< centre of column (0, 0)
  double spacing_mm = 1;
  std::vector<double> values;

  /// The centre of a column.
  [[nodiscard]] Vec2 place_mm(int i, int j) const { return corner_mm + spacing_mm * Vec2(i, j); }
  /// Bilinear; the nearest column's value beyond the raster.
  [[nodiscard]] double at(const Vec2& place_mm) const;
};

/// Smooths values by local least squares with Gaussian weights (Cleveland and Devlin 1988,
/// doi:10.1080/01621459.1988.10478639): a quadratic in each known column, which unlike a mean has no bias where the
/// values slope or end, with lower weights for values (mm) that differ, and a plane through the nearest known columns
/// in each other column at most a few columns away. `reached` gets 1 in the columns with a value.
RasterField local_fit(const RasterField& field, const std::vector<std::uint8_t>& known,
                      std::vector<std::uint8_t>& reached);

/// The depth of reamed columns, smoothed, with a negative value in all others, so that it passes zero at the rim and
/// each contour of a value ≥ 0 is closed. `depth_mm` is used where `reamed` is 1.
RasterField signed_depth(const RasterField& depth_mm, const std::vector<std::uint8_t>& reamed);

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
