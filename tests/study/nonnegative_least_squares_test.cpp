// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/nonnegative_least_squares.h"

#include <gtest/gtest.h>

#include <random>

namespace reamsim::test {
namespace {

/// Of the unknowns, how many are 0.
int check_optimum(const Eigen::MatrixXd& a, const Eigen::VectorXd& y) {
  const Eigen::MatrixXd gram = a.transpose() * a;
  const Eigen::VectorXd right = a.transpose() * y;
  const Eigen::VectorXd x = nonnegative_least_squares(gram, right);
  const Eigen::VectorXd gradient = gram * x - right;
  const double small = 1e-9 * right.cwiseAbs().maxCoeff();
  int bound = 0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    EXPECT_GE(x[i], 0);
    if (x[i] > 0) {
      EXPECT_NEAR(gradient[i], 0, small) << "a free unknown is at its minimum";
    } else {
      EXPECT_GE(gradient[i], -small) << "more of a bound unknown would not help";
      ++bound;
    }
  }
  return bound;
}

/// The conditions of Karush, Kuhn and Tucker, which only the minimum meets.
TEST(NonnegativeLeastSquares, MeetsTheConditionsOfTheMinimum) {
  constexpr unsigned kSeed = 25;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal;
  int bound = 0, unknowns = 0;
  for (int n = 0; n < 300; ++n) {
    const Eigen::Index columns = 2 + n % 7;
    Eigen::MatrixXd a(columns + 3, columns);
    for (double& value : a.reshaped()) value = normal(random);
    // Columns that resemble each other: unknowns that were freed early have to go back to 0.
    for (Eigen::Index c = 1; c < columns; ++c) a.col(c) = 0.8 * a.col(c - 1) + 0.6 * a.col(c);
    if (n % 3 == 0) a.col(columns - 1) *= 1e6;
    Eigen::VectorXd y = a * Eigen::VectorXd::Ones(columns);
    for (double& value : y) value += 4 * normal(random);
    bound += check_optimum(a, y);
    unknowns += static_cast<int>(columns);
  }
  EXPECT_GT(bound, unknowns / 4);
  EXPECT_LT(bound, unknowns * 3 / 4);
}

TEST(NonnegativeLeastSquares, AnUnknownWithoutInfluenceIsZero) {
  Eigen::MatrixXd a(3, 3);
  a << 1, 0, 2, 1, 0, 1, 0, 0, 1;
  const Eigen::VectorXd y = Eigen::Vector3d(5, 3, 2);  // of (1, -, 2)
  const Eigen::VectorXd x = nonnegative_least_squares(a.transpose() * a, a.transpose() * y);
  EXPECT_NEAR(x[0], 1, 1e-12);
  EXPECT_EQ(x[1], 0);
  EXPECT_NEAR(x[2], 2, 1e-12);
}

}  // namespace
}  // namespace reamsim::test
