// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/pictures/contour_lines.h"
#include "sim/base/geometry.h"

namespace reamsim {

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
  [[nodiscard]] Vec2 min_mm() const { return depth_.corner_mm - Vec2::Constant(0.5 * spacing_mm()); }
  [[nodiscard]] Vec2 max_mm() const {
    return depth_.corner_mm + spacing_mm() * Vec2(depth_.raster.nx - 0.5, depth_.raster.ny - 0.5);
  }
  [[nodiscard]] double deepest_mm() const { return deepest_mm_; }
  [[nodiscard]] double mean_mm() const { return mean_mm_; }
  /// Area of the reamed columns, projected along z of the map.
  [[nodiscard]] double area_mm2() const { return area_mm2_; }
  /// Area of the perforations, without reamed rim.
  [[nodiscard]] double perforated_mm2() const { return perforated_mm2_; }

 private:
  void read_raster(const std::string& path);
  void exclude_rim_from_holes();
  void extend_depth();
  void compute_normals();
  void compute_totals();
  [[nodiscard]] RasterField with_values(std::vector<double> values) const;
  /// Calls visit(column, bilinear weight) for those of the four columns around a point that are in the raster.
  template <class Visit>
  void for_each_corner(const Along& x, const Along& y, const Visit& visit) const;

  // By column of the raster.
  RasterField depth_;  ///< mm
  RasterField signed_depth_;
  std::vector<std::uint8_t> bone_, reamed_, perforated_;
  std::vector<double> before_mm_, near_mm_;  ///< height of the unreamed surface; depth of the nearest reamed columns
  std::vector<double> bone_fraction_, reamed_fraction_;  ///< smoothed masks
  std::vector<Vec3> normals_;                            ///< of the unreamed surface
  double deepest_mm_ = 0, mean_mm_ = 0, area_mm2_ = 0, perforated_mm2_ = 0;
};

}  // namespace reamsim
