#include "sim/metrics/face_fit.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>

namespace reamsim {

namespace {

using Vec4 = Eigen::Vector4d;
using Mat4 = Eigen::Matrix4d;

Vec3 mean_of(const std::vector<Vec3>& points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

double sphere_rms(const std::vector<Vec3>& points, const SphereFit& sphere) {
  double squares = 0;
  for (const Vec3& p : points) {
    const double off = (p - sphere.center_mm).norm() - sphere.radius_mm;
    squares += off * off;
  }
  return std::sqrt(squares / static_cast<double>(points.size()));
}

/// |p|² = 2c·p + k about the mean of the points, solved by the normal equations; k = R² − |c|².
std::optional<SphereFit> algebraic_fit(const std::vector<Vec3>& points, const Vec3& mean) {
  Mat4 products = Mat4::Zero();
  Vec4 right = Vec4::Zero();
  for (const Vec3& point : points) {
    const Vec3 p = point - mean;
    const Vec4 row(2 * p.x(), 2 * p.y(), 2 * p.z(), 1);
    products += row * row.transpose();
    right += p.squaredNorm() * row;
  }
  Eigen::ColPivHouseholderQR<Mat4> solver(products);
  if (solver.rank() < 4) return std::nullopt;
  const Vec4 found = solver.solve(right);
  const double squared_radius = found.w() + found.head<3>().squaredNorm();
  if (!(squared_radius > 0)) return std::nullopt;
  return SphereFit{.center_mm = mean + found.head<3>(), .radius_mm = std::sqrt(squared_radius), .rms_mm = 0};
}

/// One Gauss–Newton step on the distances |p − c| − R; returns its length.
double refine(SphereFit& sphere, const std::vector<Vec3>& points) {
  Mat4 products = Mat4::Zero();
  Vec4 right = Vec4::Zero();
  for (const Vec3& p : points) {
    const Vec3 way = p - sphere.center_mm;
    const double distance = way.norm();
    const Vec3 unit = way / distance;
    const Vec4 row(unit.x(), unit.y(), unit.z(), 1);
    products += row * row.transpose();
    right += (distance - sphere.radius_mm) * row;
  }
  const Vec4 step = Eigen::ColPivHouseholderQR<Mat4>(products).solve(right);
  sphere.center_mm += step.head<3>();
  sphere.radius_mm += step.w();
  return step.norm();
}

}  // namespace

std::optional<PlaneFit> fit_plane(const std::vector<Vec3>& points, const Vec3& outward) {
  if (points.size() < 3) return std::nullopt;
  PlaneFit out;
  out.point_mm = mean_of(points);
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : points) spread += (p - out.point_mm) * (p - out.point_mm).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(spread / static_cast<double>(points.size()));
  constexpr double kOnALine = 1e-9;
  if (axes.eigenvalues()(1) <= kOnALine * axes.eigenvalues()(2)) return std::nullopt;
  out.normal = axes.eigenvectors().col(0).normalized();
  if (out.normal.dot(outward) < 0) out.normal = -out.normal;
  out.rms_mm = std::sqrt(std::max(axes.eigenvalues()(0), 0.0));
  return out;
}

std::optional<SphereFit> fit_sphere(const std::vector<Vec3>& points) {
  if (points.size() < 4) return std::nullopt;
  std::optional<SphereFit> sphere = algebraic_fit(points, mean_of(points));
  if (!sphere || sphere->radius_mm > kLargestRadius_mm) return std::nullopt;
  constexpr int kMaxSteps = 30;
  constexpr double kStill_mm = 1e-10;
  for (int i = 0; i < kMaxSteps && refine(*sphere, points) > kStill_mm; ++i) {
  }
  const bool sane = std::isfinite(sphere->radius_mm) && sphere->radius_mm > 0;
  if (!sane || sphere->radius_mm > kLargestRadius_mm) return std::nullopt;
  sphere->rms_mm = sphere_rms(points, *sphere);
  return sphere;
}

}  // namespace reamsim
