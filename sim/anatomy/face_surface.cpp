// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/anatomy/face_surface.h"

#include <numeric>
#include <utility>

#include "sim/base/statistics.h"

namespace reamsim {

namespace {

/// The least-squares solution of an equation for each point: equation(point) returns its row and its right side.
template <class Equation>
QrSolution solve_normal_equations(const std::vector<Vec3>& points, const Equation& equation) {
  Mat4 products = Mat4::Zero();
  Vec4 right = Vec4::Zero();
  for (const Vec3& point : points) {
    const auto [row, value] = equation(point);
    products += row * row.transpose();
    right += value * row;
  }
  return solve_qr(products, right);
}

/// |p|² = 2c·p + k about the mean of the points; k = R² − |c|².
std::optional<SphereFit> algebraic_fit(const std::vector<Vec3>& points, const Vec3& mean) {
  const auto [found, rank] = solve_normal_equations(points, [&](const Vec3& point) {
    const Vec3 p = point - mean;
    return std::pair(Vec4(2 * p.x(), 2 * p.y(), 2 * p.z(), 1), p.squaredNorm());
  });
  if (rank < 4) return std::nullopt;
  const double squared_radius = found.w() + found.head<3>().squaredNorm();
  if (!(squared_radius > 0)) return std::nullopt;
  return SphereFit{.center_mm = mean + found.head<3>(), .radius_mm = std::sqrt(squared_radius), .rms_mm = 0};
}

/// One Gauss–Newton step on the distances |p − c| − R; returns its length.
double refine(SphereFit& sphere, const std::vector<Vec3>& points) {
  const Vec4 step = solve_normal_equations(points, [&](const Vec3& point) {
                      const Vec3 way = point - sphere.center_mm;
                      const double distance = way.norm();
                      const Vec3 unit = way / distance;
                      return std::pair(Vec4(unit.x(), unit.y(), unit.z(), 1), distance - sphere.radius_mm);
                    }).x;
  sphere.center_mm += step.head<3>();
  sphere.radius_mm += step.w();
  return step.norm();
}

constexpr double kLargestRadius_mm = 1000;
/// Below a residual of the plane of this many voxels the voxels determine it.
constexpr double kFlatVoxels = 0.1;
constexpr double kSphereGain = 0.5;  // residual of a sphere that describes a reamed face over that of its plane
constexpr double kFaceEdgeVoxels = 2;
constexpr std::size_t kMinFacePoints = 25;
constexpr double kTrimmedFraction = 0.75;  // of the points, in least trimmed squares
constexpr double kNormalMad = 1.4826;      // standard deviation over median absolute deviation, of normal errors
constexpr double kFarDeviations = 2.5;
constexpr double kMinDeviation_mm = 1e-6;
constexpr int kMaxRounds = 50;
constexpr double kCorrelationVoxels = 3;
constexpr int kSectors = 8;
constexpr double kSignificant = 15.1;  // F(1, ∞) at one error in 10,000

template <class Fit>
std::vector<double> distances_of(const Fit& fit, const std::vector<Vec3>& points) {
  std::vector<double> out;
  out.reserve(points.size());
  for (const Vec3& point : points) out.push_back(std::abs(fit.distance_mm(point)));
  return out;
}

std::vector<Vec3> nearer_than(const std::vector<Vec3>& points, const std::vector<double>& distances, double most) {
  std::vector<Vec3> out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (distances[i] <= most) out.push_back(points[i]);
  }
  return out;
}

/// A fit, its inliers, and the mean square distance of the nearest kTrimmedFraction of all points.
template <class Fit>
struct RobustFit {
  Fit fit;
  std::vector<Vec3> fitted_mm;
  double trimmed_mean_square = 0;
};

template <class Fit>
double trimmed_mean_square(const Fit& fit, const std::vector<Vec3>& points) {
  std::vector<double> distances = distances_of(fit, points);
  std::sort(distances.begin(), distances.end());
  const auto count = static_cast<std::size_t>(kTrimmedFraction * static_cast<double>(points.size()));
  double squares = 0;
  for (std::size_t i = 0; i < count; ++i) squares += distances[i] * distances[i];
  return squares / static_cast<double>(count);
}

/// `make` fits a surface to points. nullopt where it fails.
template <class Fit, class Make>
std::optional<RobustFit<Fit>> fit_robustly(const std::vector<Vec3>& points, const Make& make) {
  std::optional<Fit> fit = make(points);
  if (!fit) return std::nullopt;
  std::vector<Vec3> kept;
  const auto refit = [&](const auto& limit) {
    for (int round = 0; round < kMaxRounds; ++round) {
      const std::vector<double> distances = distances_of(*fit, points);
      std::vector<Vec3> near = nearer_than(points, distances, limit(distances));
      if (near == kept) return;
      const std::optional<Fit> better = make(near);
      if (!better) return;
      fit = better;
      kept = std::move(near);
    }
  };
  refit([](const std::vector<double>& distances) { return quantile(distances, kTrimmedFraction); });
  refit([](const std::vector<double>& distances) {
    return kFarDeviations * std::max(kNormalMad * quantile(distances, 0.5), kMinDeviation_mm);
  });
  return RobustFit<Fit>{*fit, std::move(kept), trimmed_mean_square(*fit, points)};
}

/// Unit vector out of the bone at a point.
Vec3 direction_at(const SphereFit& sphere, bool concave, const Vec3& point) {
  const Vec3 away = (point - sphere.center_mm).normalized();
  return concave ? Vec3(-away) : away;
}

/// The inliers without one of kSectors sectors around their mean.
std::vector<Vec3> without_sector(const FaceSurface& surface, int sector) {
  const Vec3 across = surface.plane.normal.unitOrthogonal();
  const Vec3 other = surface.plane.normal.cross(across);
  std::vector<Vec3> out;
  for (const Vec3& p : surface.fitted_mm) {
    const Vec3 from = p - surface.plane.point_mm;
    const double turn = std::atan2(from.dot(other), from.dot(across)) / (2 * std::numbers::pi) + 0.5;
    if (std::min(static_cast<int>(turn * kSectors), kSectors - 1) != sector) out.push_back(p);
  }
  return out;
}

/// Standard error of the direction at a point by the jackknife over sectors of the face (Efron 1982, The jackknife, the
/// bootstrap and other resampling plans). It includes correlated errors and deviations of the face from the surface.
double jackknife_error_rad(const FaceSurface& surface, const Vec3& point) {
  std::vector<Vec3> directions;
  for (int sector = 0; sector < kSectors; ++sector) {
    const std::vector<Vec3> rest = without_sector(surface, sector);
    if (surface.spherical) {
      if (const auto sphere = fit_sphere(rest)) directions.push_back(direction_at(*sphere, surface.concave, point));
    } else if (const auto plane = fit_plane(rest, surface.plane.normal)) {
      directions.push_back(plane->normal);
    }
  }
  if (directions.size() < kSectors) return std::numbers::pi;
  Vec3 mean = Vec3::Zero();
  for (const Vec3& d : directions) mean += d / kSectors;
  double squares = 0;
  for (const Vec3& d : directions) squares += (d - mean).squaredNorm();
  return std::sqrt(squares * (kSectors - 1) / kSectors);
}

/// Rotation of a plane's normal between the mean of the inliers and a point, by the curvature that the residual allows.
double hidden_curvature_rad(const FaceSurface& surface, const Vec3& point) {
  const PlaneFit& plane = surface.plane;
  double squares = 0;
  for (const Vec3& p : surface.fitted_mm) squares += (p - plane.point_mm).squaredNorm();
  squares /= static_cast<double>(surface.fitted_mm.size());
  // A paraboloid of curvature c over a disc has a residual of 0.289·c·(mean square distance from its centre).
  constexpr double kDisc = 0.289;
  const Vec3 away = point - plane.point_mm;
  return surface.rms_mm / (kDisc * squares) * (away - away.dot(plane.normal) * plane.normal).norm();
}

/// Adds the neighbours of `place` that have the group's state, and records which other states it touches.
void visit_neighbours(const ColumnMap& map, ColumnState state, const ColumnPlace& place, ColumnGroup& group,
                      std::vector<std::uint8_t>& seen) {
  const bool inner = (place.array() > 0).all() && place.x() + 1 < map.nx && place.y() + 1 < map.ny;
  group.reaches_air |= !inner;
  any_nearby(map, place, 1, [&](const ColumnPlace& next) {
    const ColumnState there = map.at(next).state;
    group.reaches_air |= there == ColumnState::air;
    group.reaches_through |= there == ColumnState::through;
    if (there == state && !std::exchange(seen[map.index(next)], true)) group.columns.push_back(next);
    return false;  // for all of them
  });
}

}  // namespace

Rigid frame_at(const Vec3& origin_mm, const Vec3& outward) {
  Rigid out;
  const Vec3 x = outward.unitOrthogonal();
  out.linear() << x, outward.cross(x), outward;
  out.translation() = origin_mm;
  return out;
}

std::optional<PlaneFit> fit_plane(const std::vector<Vec3>& points, const Vec3& outward) {
  if (points.size() < 3) return std::nullopt;
  PlaneFit out;
  const auto [mean, axes] = spread_of_points(points);
  out.point_mm = mean;
  constexpr double kOnALine = 1e-9;
  if (axes.values(1) <= kOnALine * axes.values(2)) return std::nullopt;
  out.normal = axes.vectors.col(0).normalized();
  if (out.normal.dot(outward) < 0) out.normal = -out.normal;
  out.rms_mm = std::sqrt(std::max(axes.values(0), 0.0));
  return out;
}

std::optional<SphereFit> fit_sphere(const std::vector<Vec3>& points) {
  if (points.size() < 4) return std::nullopt;
  const Vec3 sum = std::accumulate(points.begin(), points.end(), Vec3(0, 0, 0));
  std::optional<SphereFit> sphere = algebraic_fit(points, sum / static_cast<double>(points.size()));
  if (!sphere || sphere->radius_mm > kLargestRadius_mm) return std::nullopt;
  constexpr int kMaxSteps = 30;
  constexpr double kStill_mm = 1e-10;
  for (int i = 0; i < kMaxSteps && refine(*sphere, points) > kStill_mm; ++i) {
  }
  const bool sane = std::isfinite(sphere->radius_mm) && sphere->radius_mm > 0;
  if (!sane || sphere->radius_mm > kLargestRadius_mm) return std::nullopt;
  sphere->rms_mm = rms_distance_mm(*sphere, points);
  return sphere;
}

std::optional<FaceSurface> fit_face(const FacePoints& face, const Vec3& outward) {
  const std::vector<Vec3>& points = face.points_mm;
  if (points.size() < kMinFacePoints) return std::nullopt;
  auto plane = fit_robustly<PlaneFit>(points, [&](const std::vector<Vec3>& some) { return fit_plane(some, outward); });
  if (!plane) return std::nullopt;
  auto sphere = fit_robustly<SphereFit>(points, fit_sphere);
  FaceSurface out;
  out.plane = plane->fit;
  out.points = points.size();
  const double patch_mm = kCorrelationVoxels * face.voxel_mm;
  const double independent_fraction = std::min(1.0, face.point_mm2 / (patch_mm * patch_mm));
  if (sphere) {
    out.sphere = sphere->fit;
    const double gain = plane->trimmed_mean_square - sphere->trimmed_mean_square;
    const double freedom = independent_fraction * kTrimmedFraction * static_cast<double>(points.size()) - 4;
    const double flat_mm = kFlatVoxels * face.voxel_mm;
    out.spherical = freedom > 0 && gain * freedom > kSignificant * sphere->trimmed_mean_square &&
                    plane->trimmed_mean_square > flat_mm * flat_mm;
    out.concave = (sphere->fit.center_mm - out.plane.point_mm).dot(outward) > 0;
  }
  out.fitted_mm = std::move(out.spherical ? sphere->fitted_mm : plane->fitted_mm);
  out.rms_mm = out.spherical ? sphere->fit.rms_mm : plane->fit.rms_mm;
  out.fitted_fraction = static_cast<double>(out.fitted_mm.size()) / static_cast<double>(points.size());
  return out;
}

std::optional<FaceAxis> axis_through(const FaceSurface& surface, const Vec3& point) {
  if (!surface.spherical) {
    const Vec3& normal = surface.plane.normal;
    const Vec3 on_plane = point - surface.plane.distance_mm(point) * normal;
    return FaceAxis{
        on_plane, normal,
        degrees_of(std::hypot(jackknife_error_rad(surface, on_plane), hidden_curvature_rad(surface, on_plane)))};
  }
  const SphereFit& sphere = *surface.sphere;
  const Vec3 away = point - sphere.center_mm;
  constexpr double kNextToCenter = 0.5;
  if (away.norm() < kNextToCenter * sphere.radius_mm) return std::nullopt;
  const Vec3 unit = away.normalized();
  return FaceAxis{sphere.center_mm + sphere.radius_mm * unit, direction_at(sphere, surface.concave, point),
                  degrees_of(jackknife_error_rad(surface, point))};
}

std::optional<Vec3> meeting_point(const FaceSurface& surface, const Vec3& on_line, const Vec3& direction) {
  if (!surface.spherical) {
    const double slope = direction.dot(surface.plane.normal);
    constexpr double kGrazing = 0.1;
    if (std::abs(slope) < kGrazing) return std::nullopt;
    return on_line - surface.plane.distance_mm(on_line) / slope * direction;
  }
  const Vec3 from = on_line - surface.sphere->center_mm;
  const double along = from.dot(direction);
  const double radius = surface.sphere->radius_mm;
  const double inside = radius * radius - (from - along * direction).squaredNorm();
  if (inside <= 0) return std::nullopt;
  const Vec3 near = on_line - (along + std::sqrt(inside)) * direction;
  const Vec3 far = on_line - (along - std::sqrt(inside)) * direction;
  const Vec3& middle = surface.plane.point_mm;
  return (near - middle).norm() <= (far - middle).norm() ? near : far;
}

double ReamedFace::height_mm(const Vec3& point) const {
  if (!spherical) return plane->distance_mm(point);
  return concave ? -sphere->distance_mm(point) : sphere->distance_mm(point);
}

Vec3 ReamedFace::inward(const Vec3& point) const {
  if (!spherical) return -plane->normal;
  return -direction_at(*sphere, concave, point);
}

int face_edge_columns(const ColumnMap& map, double voxel_mm) {
  return static_cast<int>(std::ceil(kFaceEdgeVoxels * voxel_mm / map.pitch_mm));
}

std::vector<ColumnGroup> group_columns(const ColumnMap& map, ColumnState state) {
  std::vector<ColumnGroup> groups;
  std::vector<std::uint8_t> seen(map.columns.size(), 0);
  map.for_each([&](const ColumnPlace& start) {
    if (map.at(start).state != state || std::exchange(seen[map.index(start)], true)) return;
    ColumnGroup group;
    group.columns.push_back(start);
    for (std::size_t k = 0; k < group.columns.size(); ++k) {
      const ColumnPlace place = group.columns[k];
      visit_neighbours(map, state, place, group, seen);
    }
    groups.push_back(std::move(group));
  });
  return groups;
}

ReamedFace find_face(const ColumnMap& map, double voxel_mm) {
  ReamedFace face;
  if (map.columns.empty()) return face;
  const int edge = face_edge_columns(map, voxel_mm);
  const auto is_other = [&map](const ColumnPlace& place) { return map.at(place).state != ColumnState::reamed; };
  std::vector<Vec3> after;
  std::vector<Vec3> before;
  map.for_each([&](const ColumnPlace& place) {
    const bool inner = (place.array() >= edge).all() && place.x() < map.nx - edge && place.y() < map.ny - edge;
    if (!inner || any_nearby(map, place, edge, is_other)) return;
    face.columns.push_back(place);
    after.push_back(map.in_bone(place, map.at(place).after_mm));
    before.push_back(map.in_bone(place, map.at(place).before_mm));
  });
  const Vec3 up = map.bone_from_map.linear().col(2);
  face.plane = fit_plane(after, up);
  face.plane_before = fit_plane(before, up);
  face.sphere = fit_sphere(after);
  if (face.sphere && face.plane) {
    const double plane_mm = face.plane->rms_mm;
    face.spherical = plane_mm > kFlatVoxels * voxel_mm && face.sphere->rms_mm <= kSphereGain * plane_mm;
    face.concave = (face.sphere->center_mm - face.plane->point_mm).dot(face.plane->normal) > 0;
  }
  return face;
}

}  // namespace reamsim
