// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "sim/anatomy/column_map.h"
#include "sim/base/geometry.h"

namespace reamsim {

/// The frame at a point with a normal as +z, rotated about it in any way.
Rigid frame_at(const Vec3& origin_mm, const Vec3& outward);

/// The plane with the least sum of squared distances.
struct PlaneFit {
  Vec3 point_mm = Vec3::Zero();  ///< the points' mean
  Vec3 normal = Vec3::UnitZ();   ///< of length 1
  double rms_mm = 0;             ///< root mean square distance of the points

  /// Positive on the side of the normal.
  [[nodiscard]] double distance_mm(const Vec3& point) const { return (point - point_mm).dot(normal); }
};

/// The sphere with the least sum of squared distances from its surface.
struct SphereFit {
  Vec3 center_mm = Vec3::Zero();
  double radius_mm = 0;
  double rms_mm = 0;

  /// Positive outside.
  [[nodiscard]] double distance_mm(const Vec3& point) const { return (point - center_mm).norm() - radius_mm; }
};

/// Fits a plane; its normal points to the side of `outward`. nullopt for fewer than three points, or points on a line.
std::optional<PlaneFit> fit_plane(const std::vector<Vec3>& points_mm, const Vec3& outward);

/// Fits a sphere: the algebraic fit (linear in centre and R² − |c|²), refined by Gauss–Newton on the distances. nullopt
/// for fewer than four points, or points so flat that the radius would exceed a metre.
std::optional<SphereFit> fit_sphere(const std::vector<Vec3>& points_mm);

/// A sphere or plane fitted robustly: up to a quarter of the points may be outliers (rim, osteophytes, holes). Least
/// trimmed squares (Rousseeuw and Van Driessen 2006, Data Mining and Knowledge Discovery 12, 29–45) by concentration
/// steps from the fit of all points, then least squares of the points within 2.5 robust standard deviations.
struct FaceSurface {
  bool spherical = false;  ///< whether the sphere describes the face
  PlaneFit plane;
  std::optional<SphereFit> sphere;
  bool concave = false;         ///< the centre of the sphere lies outside the bone
  std::size_t points = 0;       ///< number of points given
  double fitted_fraction = 0;   ///< of the points: inliers of the fit
  double rms_mm = 0;            ///< of the inliers
  std::vector<Vec3> fitted_mm;  ///< the inliers

  [[nodiscard]] double distance_mm(const Vec3& point) const {
    return spherical ? sphere->distance_mm(point) : plane.distance_mm(point);
  }
};

/// Root mean square distance of points from a plane, sphere or face, mm.
template <class Surface>
double rms_distance_mm(const Surface& surface, const std::vector<Vec3>& points) {
  double squares = 0;
  for (const Vec3& point : points) {
    const double off = surface.distance_mm(point);
    squares += off * off;
  }
  return std::sqrt(squares / static_cast<double>(points.size()));
}

inline double degrees_of(double radians) {
  return radians * 180 / std::numbers::pi;
}

struct FacePoints {
  std::vector<Vec3> points_mm;
  double point_mm2 = 0;  ///< area of the face per point
  double voxel_mm = 0;   ///< errors are correlated within three voxels
};

/// The surface through the points. It is a sphere where an F test rejects the plane (error probability 1:10,000) and
/// the residual of the plane exceeds 0.1 voxels; otherwise a plane. nullopt for points on a line, or fewer than 25.
std::optional<FaceSurface> fit_face(const FacePoints& face, const Vec3& outward);

/// An axis of a face, out of the bone.
struct FaceAxis {
  Vec3 point_mm = Vec3::Zero();  ///< its intersection with the surface
  Vec3 direction = Vec3::UnitZ();
  double error_deg = 0;  ///< standard error of the direction
};

/// The line through the centre of the sphere and a point, or the normal of the plane. nullopt close to the centre.
std::optional<FaceAxis> axis_through(const FaceSurface& surface, const Vec3& point_mm);

/// The intersection of a line and the surface that is nearer to the points. nullopt where they do not meet.
std::optional<Vec3> meeting_point(const FaceSurface& surface, const Vec3& on_line_mm, const Vec3& direction);

/// The reamed face, and the surface before reaming. A sphere describes it if its residual is at most half of that of
/// the plane, which exceeds 0.1 voxels: below that the voxels determine the residual, and the face counts as flat.
struct ReamedFace {
  std::vector<ColumnPlace> columns;  ///< reamed, with all columns within face_edge_columns()
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

ReamedFace find_face(const ColumnMap& map, double voxel_mm);

/// Two voxels in columns of the map: columns nearer than this to an unreamed one mix face and wall.
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
