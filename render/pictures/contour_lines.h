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

/// Smooths by local least squares with Gaussian weights (Cleveland and Devlin 1988,
/// doi:10.1080/01621459.1988.10478639): a quadratic in known columns, which has no bias at slopes and ends; a plane in
/// others a few columns away; NaN beyond. Only columns in `wanted`, if it is not empty; the others keep their values.
RasterField local_fit(const RasterField& field, const std::vector<std::uint8_t>& known,
                      const std::vector<std::uint8_t>& wanted = {});

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

/// depth_map.csv as a raster: the depth of the removed bone along −z of the map's frame.
class DepthField {
 public:
  /// Throws InputError: unreadable, damaged, or not on a regular grid.
  explicit DepthField(const std::string& path);

  /// A point of the map, interpolated between the columns' centres.
  struct Sample {
    double bone = 0;        ///< fraction of bone, 0…1; the outline of the bone is at ½
    double reamed = 0;      ///< fraction of reamed columns, 0…1
    double perforated = 0;  ///< fraction of columns in a perforation, 0…1
    double depth_mm = 0;    ///< of the reamed columns
    double smooth_mm = 0;   ///< their smoothed depth, for colours and contour lines
  };
  /// Where points with one coordinate lie along an axis: the column before, and the weights of that and the next one.
  struct Along {
    int column;
    double low, high;
  };
  [[nodiscard]] Along along(int axis, double place_mm) const;
  [[nodiscard]] Sample at(const Along& x, const Along& y) const;
  /// Normal of the unreamed surface; +z without bone.
  [[nodiscard]] Vec3 normal_before(const Along& x, const Along& y) const;

  /// The smoothed depth with negative values outside the rim, for contour lines.
  [[nodiscard]] const RasterField& signed_depth_mm() const { return signed_depth_; }
  /// Smooth outlines, closed: of the bone, with what was perforated, and of its reamed face.
  [[nodiscard]] std::vector<ContourLine> bone_outlines() const;
  [[nodiscard]] std::vector<ContourLine> reamed_outlines() const;

  [[nodiscard]] double spacing_mm() const { return depth_.spacing_mm; }
  /// The box of the bone, without specks beside it.
  [[nodiscard]] const Eigen::AlignedBox2d& shown_mm() const { return shown_mm_; }
  [[nodiscard]] double deepest_mm() const { return deepest_mm_; }
  [[nodiscard]] double mean_mm() const { return mean_mm_; }
  /// Area of the reamed columns, projected along z of the map.
  [[nodiscard]] double area_mm2() const { return area_mm2_; }
  /// Area of the perforations, without reamed rim.
  [[nodiscard]] double perforated_mm2() const { return perforated_mm2_; }

 private:
  void read_raster(const std::string& path);
  void frame_bone();
  void exclude_rim_from_holes();
  void extend_depth();
  void compute_normals();
  void compute_totals();
  /// Calls visit(column, bilinear weight) for those of the four columns around a point that are in the raster.
  template <class Visit>
  void for_each_corner(const Along& x, const Along& y, const Visit& visit) const;

  // By column of the raster.
  RasterField depth_;  ///< mm
  RasterField signed_depth_;
  Eigen::AlignedBox2d shown_mm_;
  std::vector<std::uint8_t> bone_, reamed_, perforated_;
  std::vector<double> before_mm_, near_mm_;  ///< height of the unreamed surface; depth of the nearest reamed columns
  std::vector<double> bone_fraction_, reamed_fraction_;  ///< smoothed masks
  std::vector<Vec3> normals_;                            ///< of the unreamed surface
  double deepest_mm_ = 0, mean_mm_ = 0, area_mm2_ = 0, perforated_mm2_ = 0;
};

}  // namespace reamsim
