// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Sobol indices, quantiles and bands against closed forms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>

#include "sim/study/nonnegative_least_squares.h"
#include "sim/study/sensitivity.h"

namespace reamsim::test::sensitivity_tests {
namespace {

/// The radical inverse of `n`: a point of van der Corput's sequence.
double radical_inverse(int n, int base) {
  double out = 0;
  for (double digit = 1.0 / base; n > 0; n /= base, digit /= base) out += digit * (n % base);
  return out;
}

/// Points of Halton's sequence, uniform in 0…1. `first`: number of the first base.
Eigen::MatrixXd halton(int count, int inputs, int first) {
  constexpr int kBases[] = {2, 3, 5, 7, 11, 13, 17, 19};
  Eigen::MatrixXd out(count, inputs);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < inputs; ++j) out(i, j) = radical_inverse(i + 1, kBases[first + j]);
  return out;
}

TEST(Sensitivity, SobolIndicesOfAProduct) {
  // x·y·z of independent inputs with coefficients of variation c: V + 1 = Π(1 + c²), first order c²/V, total
  // c²·Π'(1 + c²)/V, relative to the squared mean.
  const double mean[] = {0.15, 0.5, 2.0}, half[] = {0.1, 0.2, 0.4};
  double all = 1, squares[3];
  for (int i = 0; i < 3; ++i) {
    squares[i] = half[i] * half[i] / (3 * mean[i] * mean[i]);
    all *= 1 + squares[i];
  }
  constexpr int kSamples = 1 << 14;
  const auto scaled = [&](Eigen::MatrixXd unit) {
    for (int j = 0; j < 3; ++j) unit.col(j) = (mean[j] + half[j] * (2 * unit.col(j).array() - 1)).matrix();
    return unit;
  };
  const auto product = [](const Eigen::VectorXd& x) {
    Eigen::VectorXd out(2);
    out << 1000 * x.prod(), x[0];
    return out;
  };
  const auto found = sobol_indices(scaled(halton(kSamples, 3, 0)), scaled(halton(kSamples, 3, 3)), product);
  ASSERT_EQ(found.size(), 2U);
  for (std::size_t i = 0; i < 3; ++i) {
    const double first = squares[i] / (all - 1), total = squares[i] * all / (1 + squares[i]) / (all - 1);
    std::cout << "input " << i << ": first " << found[0].first[i] << " of " << first << ", total " << found[0].total[i]
              << " of " << total << '\n';
    EXPECT_NEAR(found[0].first[i], first, 0.01);
    EXPECT_NEAR(found[0].total[i], total, 0.01);
    EXPECT_NEAR(found[1].first[i], i == 0 ? 1 : 0, 0.01);
    EXPECT_NEAR(found[1].total[i], i == 0 ? 1 : 0, 0.01);
  }
  EXPECT_NEAR(found[0].mean / (1000 * 0.15 * 0.5 * 2), 1, 1e-3);
  EXPECT_NEAR(found[0].variance / (150 * 150 * (all - 1)), 1, 0.01);
  EXPECT_THAT(dominant_inputs(found[0], {"u0", "k_n", "depth"}), ::testing::StartsWith("u0 ("));
}

// u·(1 + x/2) of inputs in ±1: in independent samples the intervals have the true indices in 95 % of all cases.
TEST(Sensitivity, IntervalsHaveTheTrueIndices) {
  static constexpr int kTrials = 400, kSamples = 64;
  std::mt19937_64 random(5);
  const auto sample = [&random] {
    Eigen::MatrixXd out(kSamples, 2);
    for (int i = 0; i < kSamples; ++i)
      for (int j = 0; j < 2; ++j) out(i, j) = std::ldexp(static_cast<double>(random() >> 11), -52) - 1;
    return out;
  };
  // V = 1/3·(1 + 1/12); the first order of x is 0.
  const double first[] = {12.0 / 13, 0}, total[] = {1, 1.0 / 13};
  int first_within[2] = {}, total_within[2] = {};
  for (int trial = 0; trial < kTrials; ++trial) {
    const Eigen::MatrixXd a = sample(), b = sample();
    const auto found = sobol_indices(a, b, [](const Eigen::VectorXd& x) {
      return Eigen::VectorXd(Eigen::VectorXd::Constant(1, x[0] * (1 + 0.5 * x[1])));
    })[0];
    for (std::size_t i = 0; i < 2; ++i) {
      first_within[i] += std::abs(found.first[i] - first[i]) <= found.first_error[i] ? 1 : 0;
      total_within[i] += std::abs(found.total[i] - total[i]) <= found.total_error[i] ? 1 : 0;
    }
  }
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(static_cast<double>(first_within[i]) / kTrials, 0.95, 0.05) << i;
    EXPECT_NEAR(static_cast<double>(total_within[i]) / kTrials, 0.95, 0.05) << i;
  }
}

TEST(Sensitivity, AnIndexAboveOneHasItsError) {
  const SobolIndices found{
      .first = {1.02}, .total = {1.01}, .first_error = {0.06}, .total_error = {0.03}, .mean = 1, .variance = 1};
  EXPECT_EQ(dominant_inputs(found, {"depth"}), "depth (102 ± 6 % of the variance alone, 101 ± 3 % in total) dominates");
}

TEST(Sensitivity, AConstantHasNoIndices) {
  const auto found = sobol_indices(halton(64, 2, 0), halton(64, 2, 2), [](const Eigen::VectorXd&) {
    return Eigen::VectorXd(Eigen::VectorXd::Constant(1, 3.0));
  });
  EXPECT_THAT(found[0].first, ::testing::ElementsAre(0, 0));
  EXPECT_EQ(dominant_inputs(found[0], {"a", "b"}), "the output does not vary");
}

TEST(NonnegativeLeastSquares, KeepsNegativeUnknownsAtZero) {
  Eigen::MatrixXd a(4, 3);
  a << 1, 0, 1, 0, 1, 1, 1, 1, 0, 2, 1, 1;
  const Eigen::Vector3d wanted(2, 0, 3);
  const Eigen::VectorXd y = a * wanted;
  EXPECT_LT((nonnegative_least_squares(a.transpose() * a, a.transpose() * y) - wanted).norm(), 1e-9);
  // Karush, Kuhn and Tucker: x >= 0, gradient <= 0, and one of both 0.
  const Eigen::Vector4d other(1, -3, 0.5, -1);
  const Eigen::VectorXd x = nonnegative_least_squares(a.transpose() * a, a.transpose() * other);
  const Eigen::VectorXd gradient = a.transpose() * (other - a * x);
  for (int i = 0; i < 3; ++i) {
    EXPECT_GE(x[i], 0);
    EXPECT_LE(gradient[i], 1e-9);
    EXPECT_NEAR(x[i] * gradient[i], 0, 1e-9);
  }
}

}  // namespace
}  // namespace reamsim::test::sensitivity_tests
