// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

struct Fractions {
  double before = 0;
  double after = 0;
  double dense = 0;  ///< bone after reaming whose density is at least the threshold
};

/// Fractions of bone, trilinear between centres of voxels, air outside the lattice. Not thread-safe: caches a brick.
class BoneFractions {
 public:
  /// `dense_g_cm3`: the least density of dense bone.
  BoneFractions(const BoneView& bone, double dense_g_cm3);

  [[nodiscard]] Fractions at(const Vec3& point_mm);

 private:
  struct BrickView {
    Vec3i coord = Vec3i::Constant(-1);
    const GradeBricks::Brick* grade = nullptr;  ///< null: air
    const FillBricks::Brick* before = nullptr;  ///< null: whole
    const FillBricks::Brick* after = nullptr;
  };

  void select_brick(const Vec3i& brick);
  void add(int offset, double weight, Fractions& sum) const;

  const BoneView bone_;
  double voxels_per_mm_;
  BrickLattice bricks_;
  int dense_grade_;
  BrickView view_;
};

/// The least grade whose density is at least `dense_g_cm3`.
int least_dense_grade(double dense_g_cm3);

/// What a line of sight along −z of the map meets.
enum class ColumnState : std::uint8_t {
  air,      ///< no bone near the reamed region
  bone,     ///< bone that was not reamed
  reamed,   ///< removed bone, and remaining bone below it
  through,  ///< removed bone, and no remaining bone below it
};

/// Heights are along z of the map, mm.
struct Column {
  ColumnState state = ColumnState::air;
  double before_mm = 0;  ///< the surface before reaming; in a reamed column after_mm + depth_mm
  double after_mm = 0;   ///< the remaining surface; undefined for `through`
  double depth_mm = 0;   ///< length of removed bone
  double cover = 0;  ///< fraction of remaining bone under the surface, 0…1: below 1 beside a wall along the column

  [[nodiscard]] bool has_bone() const { return state == ColumnState::bone || state == ColumnState::reamed; }
};

using ColumnPlace = Eigen::Vector2i;

/// The bone before and after reaming, seen along −z of a frame: a regular grid of columns over x and y. Heights are
/// integrals of the fraction of bone along a column, as in volume-of-fluid methods (Cummins, Francois and Kothe 2005,
/// Computers & Structures 83, 425–434): exact for planes across the column, and the depths sum to the removed volume.
struct ColumnMap {
  Rigid bone_from_map = Rigid::Identity();
  double pitch_mm = 0;
  Vec2 corner_mm = Vec2::Zero();  ///< centre of column (0, 0)
  int nx = 0;
  int ny = 0;
  std::vector<Column> columns;  ///< x fastest

  [[nodiscard]] std::size_t index(const ColumnPlace& p) const {
    return static_cast<std::size_t>(p.x()) + static_cast<std::size_t>(nx) * static_cast<std::size_t>(p.y());
  }
  [[nodiscard]] const Column& at(const ColumnPlace& p) const { return columns[index(p)]; }
  [[nodiscard]] bool contains(const ColumnPlace& p) const {
    return p.x() >= 0 && p.y() >= 0 && p.x() < nx && p.y() < ny;
  }
  [[nodiscard]] Vec2 center_mm(const ColumnPlace& p) const { return corner_mm + pitch_mm * p.cast<double>(); }
  /// A point of a column in B.
  [[nodiscard]] Vec3 in_bone(const ColumnPlace& p, double z_mm) const {
    const Vec2 xy = center_mm(p);
    return bone_from_map * Vec3(xy.x(), xy.y(), z_mm);
  }
  /// Calls visit(place) for all columns, x fastest.
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) visit(ColumnPlace(i, j));
    }
  }
};

/// With less removed bone than this, in voxels, a column is not reamed; with less remaining bone it is reamed through.
inline constexpr double kMinDepthVoxels = 0.1;
inline constexpr int kMaxColumns = 320;  ///< a map has at most about this many columns along an edge

/// What a map covers, mm.
struct MapExtent {
  double margin_mm = 0;      ///< around the region that lost bone
  double radius_mm = 0;      ///< at least this far from x = y = 0
  bool around_axis = false;  ///< covers the square of radius_mm alone, not the region that lost bone
  double below_mm = 0;       ///< columns reach at least this far below that region
  double pitch_mm = 0;       ///< least distance of columns; 0: one voxel
};

/// The unreamed surface on a line of sight.
struct SurfaceColumn {
  double height_mm = 0;
  bool reamed = false;  ///< half a voxel below the surface, less than half of the bone remains
};

/// The unreamed surface at (x, y) of a map, mm; nullopt where the line of sight meets no bone, or starts inside bone.
using SurfaceProbe = std::function<std::optional<SurfaceColumn>(const Vec2& place_mm)>;

/// Lines of sight along −z of `bone_from_map`, from `top_mm` down to `bottom_mm`.
SurfaceProbe probe_surface(const BoneView& bone, const Rigid& bone_from_map, double top_mm, double bottom_mm);

/// The map of the region that lost bone. It has no columns when none was lost.
ColumnMap map_columns(const BoneView& bone, const Rigid& bone_from_map, const MapExtent& extent);

/// Calls visit(voxel, grade, fill before, fill after) for every voxel that lost bone.
template <class Visit>
void for_each_cut_voxel(const BoneView& bone, const Visit& visit) {
  bone.fill.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& after) {
    const GradeBricks::Brick* grades = bone.voxmap.grade.brick(coord);
    if (grades == nullptr) return;
    const FillBricks::Brick* before = bone.fill_before.brick(coord);
    for (int offset = 0; offset < FillBricks::kVoxels; ++offset) {
      const auto at = static_cast<std::size_t>(offset);
      const std::uint16_t fill_before = before == nullptr ? FillBricks::kWhole : (*before)[at];
      if ((*grades)[at] == 0 || after[at] >= fill_before) continue;
      visit(BrickLattice::voxel_at(coord, offset), (*grades)[at], fill_before, after[at]);
    }
  });
}

/// Lengths of bone along the columns of a map: integrals of its fraction. Not thread-safe, as BoneFractions.
class ColumnBone {
 public:
  /// `map` must outlive the object. `dense_g_cm3`: the least density of dense bone.
  ColumnBone(const BoneView& bone, const ColumnMap& map, double dense_g_cm3);

  [[nodiscard]] double voxel_mm() const { return voxel_mm_; }

  struct Length {
    double bone_mm = 0;   ///< remaining bone
    double dense_mm = 0;  ///< of that, dense bone
  };
  /// The bone in the layer of `depth_mm` below the height `top_mm` of the map.
  [[nodiscard]] Length layer(const ColumnPlace& place, double top_mm, double depth_mm);

  /// The fraction of remaining bone at a height of the map.
  [[nodiscard]] double fraction(const ColumnPlace& place, double z_mm) {
    return fractions_.at(map_.in_bone(place, z_mm)).after;
  }
  /// The largest fraction of remaining bone between two heights of the map.
  [[nodiscard]] double largest_fraction(const ColumnPlace& place, double top_mm, double bottom_mm);

  /// The length of bone without a gap below a surface at the height `top_mm`, down to `bottom_mm` at most; before or
  /// after reaming. A column beside a wall is filled to the fraction `cover`; elsewhere it is 1.
  [[nodiscard]] double continuous_mm(const ColumnPlace& place, double top_mm, double bottom_mm, double cover,
                                     double Fractions::*state);

 private:
  /// Calls visit(fractions, length of the step, mm below `top_mm`) from above the surface down until it returns false.
  template <class Visit>
  void descend(const ColumnPlace& place, double top_mm, double bottom_mm, const Visit& visit);

  const ColumnMap& map_;
  BoneFractions fractions_;
  double voxel_mm_;
};

}  // namespace reamsim
