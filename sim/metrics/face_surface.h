#pragma once

#include <optional>
#include <vector>

#include "sim/metrics/face_fit.h"

namespace reamsim {

/// A sphere or plane fitted to points of a face, most of which lie on it: up to a quarter may lie anywhere else (rim,
/// osteophytes, holes) without turning the fit.
///
/// Least trimmed squares (Rousseeuw and Van Driessen 2006, Data Mining and Knowledge Discovery 12, 29–45: concentration
/// steps, here from the least-squares fit of all points), then least squares of the points within 2.5 robust standard
/// deviations (Rousseeuw and Leroy 1987). No random numbers: the same points give the same fit.
struct FaceSurface {
  bool spherical = false;  ///< which of the two describes the face
  PlaneFit plane;
  std::optional<SphereFit> sphere;
  bool concave = false;        ///< the sphere's centre lies outside the bone
  std::size_t points = 0;      ///< given
  double fitted_fraction = 0;  ///< of the points that lie on the surface, so that it was fitted to them
  double rms_mm = 0;           ///< of these
  std::vector<Vec3> fitted_mm;
};

/// What is known of the points beside their places.
struct FacePoints {
  std::vector<Vec3> points_mm;
  double point_mm2 = 0;  ///< area of the face that a point stands for
  double voxel_mm = 0;   ///< errors of points within three voxels of each other count as one
};

/// The surface through the points. It is a sphere where an F test rejects the plane (its residual exceeds the sphere's
/// beyond chance, one error in 10,000) and the plane's residual exceeds kFlatVoxels; otherwise a plane. Nothing for
/// points on a line, or fewer than kMinFacePoints.
std::optional<FaceSurface> fit_face(const FacePoints& points, const Vec3& outward);

inline constexpr std::size_t kMinFacePoints = 25;
/// A face of which less lies on one surface is not one surface.
inline constexpr double kMinFittedFraction = 0.7;

/// An axis of a face, out of the bone.
struct FaceAxis {
  Vec3 point_mm = Vec3::Zero();  ///< where it meets the surface
  Vec3 direction = Vec3::UnitZ();
  double error_deg = 0;  ///< standard error of the direction
};

/// The line through the sphere's centre and a point, which is taken along it to the sphere; for a plane its normal.
/// Nothing for a point next to the sphere's centre.
std::optional<FaceAxis> axis_through(const FaceSurface& surface, const Vec3& point_mm);

/// Where a line meets the surface, on the side of its points. Nothing where it does not.
std::optional<Vec3> meeting_point(const FaceSurface& surface, const Vec3& on_line_mm, const Vec3& direction);

}  // namespace reamsim
