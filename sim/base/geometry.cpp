// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/geometry.h"

#include <fmt/core.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>

namespace reamsim {

Quat smallest_rotation(const Vec3& from, const Vec3& to) {
  const Vec3 start = from.normalized(), end = to.normalized();
  const double cosine = end.dot(start);
  if (cosine < -1 + 1e-12) {
    const Vec3 across = start.unitOrthogonal();
    return {0, across.x(), across.y(), across.z()};
  }
  // Half-angle formulas: |axis| is the sine, and twice_cosine / 2 the cosine of half the angle.
  const Vec3 axis = start.cross(end);
  const double twice_cosine = std::sqrt((1 + cosine) * 2);
  const double inverse = 1 / twice_cosine;
  return {twice_cosine * 0.5, axis.x() * inverse, axis.y() * inverse, axis.z() * inverse};
}

Vec3 solve_ldlt(const Mat3& a, const Vec3& b) {
  return a.ldlt().solve(b);
}

Vec4 solve_ldlt(const Mat4& a, const Vec4& b) {
  return a.ldlt().solve(b);
}

Vec6 solve_ldlt(const Mat6& a, const Vec6& b) {
  return a.ldlt().solve(b);
}

QrSolution solve_qr(const Mat4& a, const Vec4& b) {
  const Eigen::ColPivHouseholderQR<Mat4> decomposed(a);
  return {decomposed.solve(b), static_cast<int>(decomposed.rank())};
}

Vec3 solve_three(const Mat3& a, const Vec3& b) {
  return a.colPivHouseholderQr().solve(b);
}

Eigen::VectorXd least_squares(const TermMatrix& terms, const Eigen::VectorXd& values) {
  return terms.colPivHouseholderQr().solve(values);
}

SymmetricEigen<2> symmetric_eigen(const Mat2& matrix) {
  const double mean = 0.5 * (matrix(0, 0) + matrix(1, 1)), half_difference = 0.5 * (matrix(0, 0) - matrix(1, 1));
  const double radius = std::hypot(half_difference, matrix(1, 0));
  const double angle = 0.5 * std::atan2(matrix(1, 0), half_difference);  // of the direction of the greater eigenvalue
  const double c = std::cos(angle), s = std::sin(angle);
  SymmetricEigen<2> out{Vec2(mean - radius, mean + radius), {}};
  out.vectors << -s, c, c, s;
  return out;
}

SymmetricEigen<3> symmetric_eigen(const Mat3& matrix) {
  const Eigen::SelfAdjointEigenSolver<Mat3> found(matrix);
  return {found.eigenvalues(), found.eigenvectors()};
}

PointSpread spread_of_points(const std::vector<Vec3>& points) {
  const auto count = static_cast<double>(points.size());
  PointSpread out;
  for (const Vec3& p : points) out.mean += p;
  out.mean /= count;
  Mat3 products = Mat3::Zero();
  for (const Vec3& p : points) products += (p - out.mean) * (p - out.mean).transpose();
  out.axes = symmetric_eigen(Mat3(products / count));
  return out;
}

std::string point_text(const Vec3& p) {
  return fmt::format("({:.1f}, {:.1f}, {:.1f})", p.x(), p.y(), p.z());
}

double angle_in_plane(const Vec3& point, const PointSpread& spread) {
  const Vec3 along = spread.axes.vectors.transpose() * (point - spread.mean);
  return std::atan2(along.y(), along.z());
}

}  // namespace reamsim
