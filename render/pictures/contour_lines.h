// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "render/pictures/overlay.h"
#include "sim/base/geometry.h"

namespace reamsim {

/// A raster of nx × ny cells, row by row.
struct Raster {
  int nx = 0;
  int ny = 0;

  [[nodiscard]] std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(i) + static_cast<std::size_t>(nx) * static_cast<std::size_t>(j);
  }
  [[nodiscard]] std::size_t count() const { return index(0, ny); }
  [[nodiscard]] bool contains(int i, int j) const { return i >= 0 && j >= 0 && i < nx && j < ny; }
  [[nodiscard]] int column(std::size_t index) const { return static_cast<int>(index) % nx; }
  [[nodiscard]] int row(std::size_t index) const { return static_cast<int>(index) / nx; }
  /// Calls visit(index) for each cell at most `reach` cells from `center` along either axis.
  template <typename Visit>
  void for_each_near(std::size_t center, int reach, const Visit& visit) const {
    const int last_i = std::min(column(center) + reach, nx - 1), last_j = std::min(row(center) + reach, ny - 1);
    for (int j = std::max(row(center) - reach, 0); j <= last_j; ++j) {
      for (int i = std::max(column(center) - reach, 0); i <= last_i; ++i) visit(index(i, j));
    }
  }
};

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

/// Smooths values (mm) by local least squares with Gaussian weights (Cleveland and Devlin 1988,
/// doi:10.1080/01621459.1988.10478639): a quadratic in each known column, which has no bias where the values slope or
/// end; a plane in others at most a few columns away; NaN beyond.
RasterField local_fit(const RasterField& field, const std::vector<std::uint8_t>& known);

/// The smoothed depth of reamed columns, with negative values in all others, so that contours of values ≥ 0 are closed.
RasterField signed_depth(const RasterField& depth_mm, const std::vector<std::uint8_t>& reamed);

/// A closed line on which a field has one value; the field is greater on its left.
struct ContourLine {
  double value = 0;
  std::vector<Vec2> points_mm;  ///< evenly spaced

  [[nodiscard]] double length_mm() const;
};

/// All lines of one value: marching squares, then smoothed along the line. Lower values surround the raster.
std::vector<ContourLine> contour_lines(const RasterField& field, double value);

/// The lines at the ticks of a legend above 0, ascending, without rings as short as those around a cannula's core.
std::vector<ContourLine> depth_contours(const RasterField& signed_depth_mm, const Scale& scale);
constexpr double kShortestContour_mm = 12;

}  // namespace reamsim
