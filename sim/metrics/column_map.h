#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "sim/metrics/bone_fractions.h"

namespace reamsim {

/// What a line of sight along −z of the map meets.
enum class ColumnState : std::uint8_t {
  air,      ///< no bone near the reamed region
  bone,     ///< bone that nothing was taken from
  reamed,   ///< lost bone, and has bone left below
  through,  ///< lost bone, and has none left below
};

/// Heights are along z of the map, mm.
struct Column {
  ColumnState state = ColumnState::air;
  double before_mm = 0;  ///< the surface before reaming; for a reamed column after_mm + depth_mm
  double after_mm = 0;   ///< the surface that is left; nothing for `through`
  double depth_mm = 0;   ///< length of bone that went
};

/// The bone before and after, seen along −z of a frame: columns in a raster over x and y.
///
/// Heights are found by integrating the bone's share along a column, the height function of volume-of-fluid methods
/// (Cummins, Francois and Kothe 2005, Computers & Structures 83, 425–434): exact for flat surfaces across the column
/// whatever part of a voxel they fill, and the depths sum up to the removed volume.
struct ColumnMap {
  Rigid bone_from_map = Rigid::Identity();
  double pitch_mm = 0;
  Vec2 corner_mm = Vec2::Zero();  ///< centre of column (0, 0)
  int nx = 0;
  int ny = 0;
  std::vector<Column> columns;  ///< x fastest

  [[nodiscard]] const Column& at(int i, int j) const {
    return columns[static_cast<std::size_t>(i) + static_cast<std::size_t>(nx) * static_cast<std::size_t>(j)];
  }
  [[nodiscard]] bool contains(int i, int j) const { return i >= 0 && j >= 0 && i < nx && j < ny; }
  [[nodiscard]] Vec2 center_mm(int i, int j) const { return corner_mm + pitch_mm * Vec2(i, j); }
  /// A point of column (i, j) in B.
  [[nodiscard]] Vec3 in_bone(int i, int j, double z_mm) const {
    const Vec2 xy = center_mm(i, j);
    return bone_from_map * Vec3(xy.x(), xy.y(), z_mm);
  }
};

/// A column that lost less than this share of a voxel's side counts as not reamed, one with less left as reamed
/// through.
inline constexpr double kMinDepthVoxels = 0.1;
/// Columns are no closer than a voxel, and about this many along an edge of the map at most.
inline constexpr int kMaxColumns = 320;

/// What a map covers beside the region that lost bone, mm.
struct MapExtent {
  double margin_mm = 0;  ///< round that region
  double radius_mm = 0;  ///< at least this far from x = y = 0
};

class ColumnScan;

/// What a line of sight meets first, before reaming.
struct SurfaceColumn {
  double height_mm = 0;  ///< of the unreamed surface
  bool reamed = false;   ///< less than half of the bone is left half a voxel below it
};

/// Lines of sight along −z of `bone_from_map`, from `top_mm` down to `bottom_mm`.
class SurfaceProbe {
 public:
  SurfaceProbe(const ReamedBone& bone, const Rigid& bone_from_map, double top_mm, double bottom_mm);
  ~SurfaceProbe();
  /// Nothing where the line meets no bone, or begins in it.
  [[nodiscard]] std::optional<SurfaceColumn> at(const Vec2& place_mm);

 private:
  std::unique_ptr<ColumnScan> scan_;
  Rigid bone_from_map_;
  double top_mm_;
};

/// The map of the region that lost bone. No columns when none was lost.
ColumnMap map_columns(const ReamedBone& bone, const Rigid& bone_from_map, const MapExtent& room);

/// Calls visit(voxel, grade, fill before, fill after) for every voxel with bone that lost some.
template <class Visit>
void for_each_cut_voxel(const ReamedBone& bone, const Visit& visit) {
  bone.fill_after.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& after) {
    const GradeBricks::Brick* grades = bone.voxmap.grade.brick(coord);
    if (grades == nullptr) return;
    const FillBricks::Brick* before = bone.fill_before.brick(coord);
    for (int offset = 0; offset < FillBricks::kVoxels; ++offset) {
      const auto at = static_cast<std::size_t>(offset);
      const std::uint16_t was = before == nullptr ? FillBricks::kWhole : (*before)[at];
      if ((*grades)[at] == 0 || after[at] >= was) continue;
      visit(BrickLattice::voxel_at(coord, offset), (*grades)[at], was, after[at]);
    }
  });
}

}  // namespace reamsim
