#pragma once

#include <array>
#include <functional>
#include <optional>
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
  /// Where a point lies along an axis of the raster: the column before it, and the weights of that and of the next one.
  /// A picture computes it once for all samples with the same coordinate.
  struct Along {
    int column;
    double low, high;
  };
  [[nodiscard]] Along along(int axis, double place_mm) const;
  [[nodiscard]] Sample at(const Along& x, const Along& y) const;
  /// `place_mm` in the map's frame.
  [[nodiscard]] Sample at(const Vec2& place_mm) const { return at(along(0, place_mm.x()), along(1, place_mm.y())); }
  /// Normal of the unreamed surface; +z without bone.
  [[nodiscard]] Vec3 normal_before(const Along& x, const Along& y) const;
  [[nodiscard]] Vec3 normal_before(const Vec2& place_mm) const {
    return normal_before(along(0, place_mm.x()), along(1, place_mm.y()));
  }

  /// The smoothed depth with negative values outside the rim, for contour lines.
  [[nodiscard]] const RasterField& signed_depth_mm() const { return signed_depth_; }
  /// Smooth outlines, closed: of the bone, with what was perforated, and of its reamed face.
  [[nodiscard]] std::vector<ContourLine> bone_outlines() const;
  [[nodiscard]] std::vector<ContourLine> reamed_outlines() const;

  [[nodiscard]] double spacing_mm() const { return spacing_mm_; }
  [[nodiscard]] Vec2 min_mm() const { return corner_mm_ - Vec2::Constant(0.5 * spacing_mm_); }
  [[nodiscard]] Vec2 max_mm() const { return corner_mm_ + spacing_mm_ * Vec2(raster_.nx - 0.5, raster_.ny - 0.5); }
  [[nodiscard]] double deepest_mm() const { return deepest_mm_; }
  [[nodiscard]] double mean_mm() const { return mean_mm_; }
  /// Area of the reamed columns, projected along z of the map.
  [[nodiscard]] double area_mm2() const { return area_mm2_; }
  /// Area of the perforations, without reamed rim.
  [[nodiscard]] double perforated_mm2() const { return perforated_mm2_; }

 private:
  struct Cell {
    bool bone = false;
    bool perforated = false;
    double bone_fraction = 0;  ///< smoothed masks
    double reamed_fraction = 0;
    double before_mm = 0;
    double depth_mm = 0;
    double smooth_mm = 0;
    double near_mm = 0;    ///< depth of the nearest reamed columns
    Vec3 normal{0, 0, 1};  ///< of the unreamed surface
  };
  /// A corner of the square of columns around a point, with its bilinear weight.
  struct Corner {
    const Cell& cell;
    double weight;
  };
  struct Row {
    Vec2 place_mm;
    Cell cell;
  };

  void build_raster(const std::vector<Row>& rows, const std::string& path);
  void exclude_rim_from_holes();
  void smooth();
  [[nodiscard]] RasterField field_of(const std::function<double(const Cell&)>& value) const;
  void smooth_outlines();
  void compute_normals();
  void compute_totals();
  [[nodiscard]] const Cell& cell(int i, int j) const;
  [[nodiscard]] std::array<Corner, 4> corners(const Along& x, const Along& y) const;

  double spacing_mm_ = 1;
  Vec2 corner_mm_ = Vec2::Zero();
  Raster raster_;
  std::vector<Cell> cells_;
  Cell outside_;  ///< stands for all that are not in the raster
  RasterField signed_depth_;
  double deepest_mm_ = 0, mean_mm_ = 0, area_mm2_ = 0, perforated_mm2_ = 0;
};

}  // namespace reamsim
