// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "sim/anatomy/column_map.h"
#include "sim/anatomy/face_surface.h"

namespace reamsim {

/// Columns nearer than this to an unreamed column mix face and wall, voxels.
inline constexpr double kFaceEdgeVoxels = 2;

/// The reamed face, and the surface before reaming.
struct ReamedFace {
  std::vector<ColumnPlace> columns;  ///< reamed, with all columns within kFaceEdgeVoxels
  std::optional<PlaneFit> plane;
  std::optional<SphereFit> sphere;
  std::optional<PlaneFit> plane_before;  ///< of the unreamed surface over the same columns
  bool spherical = false;                ///< whether the sphere describes the face
  bool concave = false;                  ///< the centre of the sphere lies outside the bone, as after a convex reamer

  /// Height of a point of B above the fitted face along its normal, mm; positive outside the bone. Needs a plane.
  [[nodiscard]] double height_mm(const Vec3& point_mm) const;
  /// Unit vector into the bone at a point of B. Needs a plane.
  [[nodiscard]] Vec3 inward(const Vec3& point_mm) const;
};

/// A sphere describes the face if its residual is at most this fraction of that of the plane, and the residual of the
/// plane exceeds kFlatVoxels. Below that the voxels determine the residual, and the face counts as flat.
inline constexpr double kSphereGain = 0.5;

ReamedFace find_face(const ColumnMap& map, double voxel_mm);

/// kFaceEdgeVoxels in columns of the map.
int face_edge_columns(const ColumnMap& map, double voxel_mm);

/// Whether `test(place)` is true for `place` or a column within `reach` columns of it along each axis.
template <class Test>
bool any_nearby(const ColumnMap& map, const ColumnPlace& place, int reach, const Test& test) {
  for (int j = std::max(place.y() - reach, 0); j <= std::min(place.y() + reach, map.ny - 1); ++j) {
    for (int i = std::max(place.x() - reach, 0); i <= std::min(place.x() + reach, map.nx - 1); ++i) {
      if (test(ColumnPlace(i, j))) return true;
    }
  }
  return false;
}

/// A group of columns that touch at least by a corner.
struct ColumnGroup {
  std::vector<ColumnPlace> columns;
  bool reaches_air = false;      ///< touches a column of air, or the border of the map
  bool reaches_through = false;  ///< touches a column that was reamed through
};
std::vector<ColumnGroup> group_columns(const ColumnMap& map, ColumnState state);

}  // namespace reamsim
