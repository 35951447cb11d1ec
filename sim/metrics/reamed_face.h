#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "sim/metrics/column_map.h"
#include "sim/metrics/face_fit.h"

namespace reamsim {

/// Place of a column in a ColumnMap.
using ColumnPlace = Eigen::Vector2i;

/// Columns nearer than this to one that is not reamed show a mixture of face and wall, voxels.
inline constexpr double kFaceEdgeVoxels = 2;

/// The face that the reamer left, and the surface that was there before.
struct ReamedFace {
  std::vector<ColumnPlace> columns;  ///< reamed, like every column within kFaceEdgeVoxels
  std::optional<PlaneFit> plane;
  std::optional<SphereFit> sphere;
  std::optional<PlaneFit> plane_before;  ///< of the unreamed surface over the same columns
  bool spherical = false;                ///< which of the two describes the face
  bool concave = false;                  ///< the sphere's centre lies outside the bone, as a convex reamer leaves it

  /// Height of a point of B over the fitted face along its normal, mm; positive outside the bone. Needs a plane.
  [[nodiscard]] double height_mm(const Vec3& point_mm) const;
  /// The way into the bone at a point of B, of length 1. Needs a plane.
  [[nodiscard]] Vec3 inward(const Vec3& point_mm) const;
};

/// A sphere describes the face where it leaves at most this share of the plane's residual, and that residual is more
/// than kFlatVoxels: below, the lattice's steps decide, and the face counts as flat.
inline constexpr double kSphereGain = 0.5;
inline constexpr double kFlatVoxels = 0.1;

ReamedFace find_face(const ColumnMap& map, double voxel_mm);

/// Whether `place` or a column within `reach` (columns, along each axis) of it has `mark` set.
bool marked_nearby(const ColumnMap& map, const std::vector<std::uint8_t>& mark, const ColumnPlace& place, int reach);

/// Groups of columns that touch, by a corner at least.
struct ColumnGroup {
  std::vector<ColumnPlace> columns;
  bool reaches_air = false;      ///< touches a column of air, or ends at the map's border
  bool reaches_through = false;  ///< touches a column that was reamed through
};
std::vector<ColumnGroup> group_columns(const ColumnMap& map, ColumnState state);

}  // namespace reamsim
