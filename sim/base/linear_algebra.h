// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/base/geometry.h"

/// Decompositions of small symmetric matrices, for least-squares fits. Functions of their own because Eigen's templates
/// take seconds to compile for each size and for each file that uses them.

namespace reamsim {

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

/// Eigenvalues of a symmetric matrix in ascending order, and their eigenvectors of length 1 as columns in the same
/// order.
struct SymmetricEigen2 {
  Vec2 values;
  Mat2 vectors;
};
struct SymmetricEigen3 {
  Vec3 values;
  Mat3 vectors;
};
/// Closed form: half the angle whose tangent is 2b/(a − c) for ((a, b), (b, c)).
SymmetricEigen2 symmetric_eigen(const Mat2& matrix);
SymmetricEigen3 symmetric_eigen(const Mat3& matrix);

}  // namespace reamsim
