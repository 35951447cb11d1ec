#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

/// depth_map.csv as a raster: what a run took from the bone, seen along −z of the map's frame.
class DepthField {
 public:
  /// Throws InputError: unreadable, damaged, or not on one raster.
  explicit DepthField(const std::string& path);

  /// What a point of the map shows, smooth between the columns' centres.
  struct Sample {
    double bone = 0;       ///< share of columns with bone round the point, 0…1; half of it is the bone's outline
    double reamed = 0;     ///< share of reamed columns, 0…1
    double through = 0;    ///< share of columns in a hole reamed through the bone, 0…1
    double depth_mm = 0;   ///< of the reamed columns
    double smooth_mm = 0;  ///< their depth averaged over neighbours, for contour lines
  };
  /// `place` in mm, in the map's frame.
  [[nodiscard]] Sample at(const Vec2& place_mm) const;
  /// Of the unreamed surface there; +z where there is no bone.
  [[nodiscard]] Vec3 normal_before(const Vec2& place_mm) const;

  [[nodiscard]] double spacing_mm() const { return spacing_mm_; }
  [[nodiscard]] Vec2 min_mm() const { return corner_mm_ - Vec2::Constant(0.5 * spacing_mm_); }
  [[nodiscard]] Vec2 max_mm() const { return corner_mm_ + spacing_mm_ * Vec2(nx_ - 0.5, ny_ - 0.5); }
  [[nodiscard]] double deepest_mm() const { return deepest_mm_; }
  [[nodiscard]] double mean_mm() const { return mean_mm_; }
  /// Of the reamed columns, across the map's z.
  [[nodiscard]] double area_mm2() const { return area_mm2_; }
  /// Of the holes that were reamed through the bone. Rim that was reamed away is no hole.
  [[nodiscard]] double perforated_mm2() const { return perforated_mm2_; }

 private:
  /// Shares of the columns round a column, weighted by nearness: outlines by them do not go along the columns' edges.
  struct Shares {
    double bone = 0;
    double reamed = 0;
  };
  struct Cell {
    bool bone = false;
    bool through = false;
    Shares shares{};
    double before_mm = 0;
    double depth_mm = 0;
    double smooth_mm = 0;
    double near_mm = 0;    ///< depth of the nearest reamed columns, where outlines leave them
    Vec3 normal{0, 0, 1};  ///< of the unreamed surface
  };
  /// A corner of the square of columns round a point.
  struct Corner {
    const Cell& cell;
    double weight;
  };
  struct Row {
    Vec2 place_mm;
    Cell cell;
  };

  static std::vector<Row> read(const std::string& path);
  void place(const std::vector<Row>& rows, const std::string& path);
  void keep_holes();
  void smooth();
  void round_off();
  void sum_up();
  void find_normals();
  [[nodiscard]] std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(i) + static_cast<std::size_t>(nx_) * static_cast<std::size_t>(j);
  }
  [[nodiscard]] const Cell& cell(int i, int j) const;
  [[nodiscard]] std::array<Corner, 4> corners(const Vec2& place_mm) const;

  double spacing_mm_ = 1;
  Vec2 corner_mm_ = Vec2::Zero();
  int nx_ = 0;
  int ny_ = 0;
  std::vector<Cell> cells_;
  double deepest_mm_ = 0;
  double mean_mm_ = 0;
  double area_mm2_ = 0;
  double perforated_mm2_ = 0;
};

}  // namespace reamsim
