// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

/// Decompositions of small symmetric matrices, for least-squares fits. Functions of their own because Eigen's templates
/// take seconds to compile for each size and for each file that uses them.

namespace reamsim {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec3i = Eigen::Vector3i;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;
/// A rigid transform. Every variable of this type is named `target_from_source`.
using Rigid = Eigen::Isometry3d;

/// The index of a cell in an array of `dims` cells: i + nx·(j + ny·k).
inline std::size_t index_in(const Vec3i& dims, const Vec3i& cell) {
  return static_cast<std::size_t>(cell.x() + std::int64_t{dims.x()} * (cell.y() + std::int64_t{dims.y()} * cell.z()));
}
/// Whether an array of `dims` cells has this one.
inline bool contains_cell(const Vec3i& dims, const Vec3i& cell) {
  return (cell.array() >= 0).all() && (cell.array() < dims.array()).all();
}
/// The cell of an index.
inline Vec3i cell_at(const Vec3i& dims, std::size_t index) {
  const auto nx = static_cast<std::size_t>(dims.x()), ny = static_cast<std::size_t>(dims.y());
  return {static_cast<int>(index % nx), static_cast<int>(index / nx % ny), static_cast<int>(index / nx / ny)};
}

/// Axis-aligned box, mm, in the frame that its owner names.
struct Aabb {
  Vec3 min = Vec3::Zero();
  Vec3 max = Vec3::Zero();

  [[nodiscard]] Vec3 center() const { return 0.5 * (min + max); }
  [[nodiscard]] Vec3 half() const { return 0.5 * (max - min); }
  /// The box with `margin` added on every side.
  [[nodiscard]] Aabb expanded(double margin) const {
    return {min - Vec3::Constant(margin), max + Vec3::Constant(margin)};
  }
  [[nodiscard]] bool empty() const { return (min.array() > max.array()).any(); }
  [[nodiscard]] bool contains(const Vec3& p) const {
    return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
  }
  /// Distance of its farthest corner from the origin.
  [[nodiscard]] double reach() const { return min.cwiseAbs().cwiseMax(max.cwiseAbs()).norm(); }
  /// Corner 0…7: bit n of the number chooses the maximum along axis n.
  [[nodiscard]] Vec3 corner(int n) const {
    return {(n & 1) != 0 ? max.x() : min.x(), (n & 2) != 0 ? max.y() : min.y(), (n & 4) != 0 ? max.z() : min.z()};
  }
  void extend(const Vec3& point) {
    min = min.cwiseMin(point);
    max = max.cwiseMax(point);
  }
  /// Contains no point; extend() makes it grow.
  static Aabb none() {
    return {Vec3::Constant(std::numeric_limits<double>::infinity()),
            Vec3::Constant(-std::numeric_limits<double>::infinity())};
  }
};

/// The glenoid frame G, mm, right-handed: origin at the glenoid centre, +z out of the bone along its normal, +y
/// superior.
struct GlenoidFrame {
  Rigid bone_from_glenoid = Rigid::Identity();

  static auto fields(auto& self) { return std::tie(self.bone_from_glenoid.matrix()); }
};

/// The directions of the scapular frame S in B, each of length 1: version and inclination are angles between them.
struct ScapularAxes {
  Vec3 lateral = Vec3::UnitX();   ///< along the Friedman axis, from the trigonum spinae to the glenoid's centre
  Vec3 superior = Vec3::UnitY();  ///< in the scapular plane
  Vec3 anterior = Vec3::UnitZ();

  static auto fields(auto& self) { return std::tie(self.lateral, self.superior, self.anterior); }
};

/// The rotation by the smallest angle that takes direction `from` to direction `to`; where they are opposite, about any
/// axis across them. Eigen's FromTwoVectors takes six seconds to compile.
Quat smallest_rotation(const Vec3& from, const Vec3& to);

/// Calls visit(begin, end) for every side of a closed polygon.
template <class Visit>
void for_each_side(const std::vector<Vec2>& corners, const Visit& visit) {
  for (std::size_t i = 0; i < corners.size(); ++i) visit(corners[i], corners[(i + 1) % corners.size()]);
}

using Mat2 = Eigen::Matrix2d;
using Mat4 = Eigen::Matrix4d;
using Vec4 = Eigen::Vector4d;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Vec6 = Eigen::Matrix<double, 6, 1>;

/// x of A·x = b, for a symmetric, positive or negative semidefinite A, by LDLᵀ with pivoting (Eigen::LDLT). Not finite,
/// or one of many solutions, if A is singular.
Vec3 solve_ldlt(const Mat3& a, const Vec3& b);
Vec4 solve_ldlt(const Mat4& a, const Vec4& b);
Vec6 solve_ldlt(const Mat6& a, const Vec6& b);

/// x of A·x = b by Householder QR with column pivoting (Eigen::ColPivHouseholderQR), and the numerical rank of A. If A
/// is singular, x is one of those with the least residual.
struct QrSolution {
  Vec4 x;
  int rank = 0;
};
QrSolution solve_qr(const Mat4& a, const Vec4& b);
/// x of A·x = b by the same decomposition; where there are more equations than unknowns, which are at most 6, the x of
/// the least residual. In this file, because Eigen's decompositions take ten seconds to compile.
Vec3 solve_three(const Mat3& a, const Vec3& b);
using TermMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, Eigen::Dynamic, 6>;
Eigen::VectorXd least_squares(const TermMatrix& terms, const Eigen::VectorXd& values);

/// Ascending eigenvalues of a symmetric matrix, and their eigenvectors of length 1 as columns in the same order.
template <int kSize>
struct SymmetricEigen {
  Eigen::Matrix<double, kSize, 1> values;
  Eigen::Matrix<double, kSize, kSize> vectors;
};
/// Closed form: half the angle whose tangent is 2b/(a − c) for ((a, b), (b, c)).
SymmetricEigen<2> symmetric_eigen(const Mat2& matrix);
SymmetricEigen<3> symmetric_eigen(const Mat3& matrix);

/// The mean of points, and their variances along the main directions.
struct PointSpread {
  Vec3 mean = Vec3::Zero();
  SymmetricEigen<3> axes;
};
PointSpread spread_of_points(const std::vector<Vec3>& points);

/// "(1.0, -2.5, 0.0)".
std::string point_text(const Vec3& p);

/// The angle of a point about the mean in the plane of the two greater variances, rad.
double angle_in_plane(const Vec3& point, const PointSpread& spread);

}  // namespace reamsim
