// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "sim/base/text.h"

namespace reamsim {
namespace {

constexpr unsigned kSeed = 20261127;
constexpr int kCases = 1000;
constexpr double kRounding = 1e-12;

class LinearAlgebra : public testing::Test {
 protected:
  void SetUp() override { RecordProperty("seed", static_cast<int>(kSeed)); }
  double any() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  Vec3 direction() {
    for (;;) {
      const Vec3 out(any(), any(), any());
      if (out.norm() > 0.1) return out.normalized();
    }
  }
  /// Symmetric and positive definite.
  template <class Matrix>
  Matrix definite() {
    Matrix root;
    for (Eigen::Index i = 0; i < root.size(); ++i) root.data()[i] = any();
    return root * root.transpose() + 0.1 * Matrix::Identity();
  }

 private:
  std::mt19937 random_{kSeed};
};

TEST_F(LinearAlgebra, SmallestRotationTurnsOneDirectionIntoTheOther) {
  for (int i = 0; i < kCases; ++i) {
    const Vec3 from = direction(), to = direction();
    const Quat turn = smallest_rotation(3 * from, 0.5 * to);
    EXPECT_NEAR((turn * from - to).norm(), 0, kRounding);
    EXPECT_NEAR(Eigen::AngleAxisd(turn).angle(), std::acos(from.dot(to)), 1e-7);
  }
}

TEST_F(LinearAlgebra, SmallestRotationOfOppositeDirectionsIsAHalfTurn) {
  for (int i = 0; i < kCases; ++i) {
    const Vec3 from = i < 3 ? Vec3(Vec3::Unit(i)) : direction();
    const Quat turn = smallest_rotation(from, -from);
    EXPECT_NEAR((turn * from + from).norm(), 0, kRounding);
    EXPECT_NEAR(turn.norm(), 1, kRounding);
  }
}

TEST_F(LinearAlgebra, EigenvectorsOfTwoByTwoBelongToAscendingEigenvalues) {
  for (int i = 0; i < kCases; ++i) {
    Mat2 matrix;
    const double across = i % 7 == 0 ? 0 : any();
    const double first = any();
    matrix << first, across, across, i % 5 == 0 ? first : any();
    const SymmetricEigen<2> found = symmetric_eigen(matrix);
    EXPECT_LE(found.values(0), found.values(1));
    const Mat2 scaled = found.vectors * found.values.asDiagonal();
    EXPECT_NEAR((matrix * found.vectors - scaled).norm(), 0, kRounding);
    EXPECT_NEAR((found.vectors.transpose() * found.vectors - Mat2::Identity()).norm(), 0, kRounding);
  }
}

TEST_F(LinearAlgebra, EigenvectorsOfThreeByThreeBelongToAscendingEigenvalues) {
  for (int i = 0; i < kCases; ++i) {
    const Mat3 matrix = definite<Mat3>();
    const SymmetricEigen<3> found = symmetric_eigen(matrix);
    EXPECT_LE(found.values(0), found.values(1));
    EXPECT_LE(found.values(1), found.values(2));
    const Mat3 scaled = found.vectors * found.values.asDiagonal();
    EXPECT_NEAR((matrix * found.vectors - scaled).norm(), 0, kRounding);
  }
}

TEST_F(LinearAlgebra, SolutionsSatisfyTheirEquations) {
  for (int i = 0; i < kCases; ++i) {
    const Mat4 matrix = definite<Mat4>();
    const Vec4 right(any(), any(), any(), any());
    EXPECT_NEAR((matrix * solve_ldlt(matrix, right) - right).norm(), 0, kRounding);
    const auto [x, rank] = solve_qr(matrix, right);
    EXPECT_NEAR((matrix * x - right).norm(), 0, kRounding);
    EXPECT_EQ(rank, 4);
  }
}

TEST(SolveQr, CountsTheRankOfASingularMatrix) {
  Mat4 matrix = Mat4::Identity();
  matrix(3, 3) = 0;
  EXPECT_EQ(solve_qr(matrix, Vec4::Ones()).rank, 3);
}

TEST(PatternTest, DescribesTheWholeText) {
  const Pattern pattern("frames/[0-9]+\\.png");
  EXPECT_TRUE(pattern.matches("frames/000012.png"));
  EXPECT_FALSE(pattern.matches("frames/000012.png.tmp"));
  EXPECT_FALSE(pattern.matches("a/frames/000012.png"));
}

}  // namespace
}  // namespace reamsim
