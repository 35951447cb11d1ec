// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/nonnegative_least_squares.h"

#include <Eigen/Cholesky>
#include <vector>

namespace reamsim {

namespace {

/// Solves for the free unknowns; the others are 0.
Eigen::VectorXd solve_free(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right, const std::vector<bool>& free) {
  std::vector<Eigen::Index> at;
  for (std::size_t i = 0; i < free.size(); ++i)
    if (free[i]) at.push_back(static_cast<Eigen::Index>(i));
  const Eigen::VectorXd part = gram(at, at).ldlt().solve(right(at));
  Eigen::VectorXd out = Eigen::VectorXd::Zero(right.size());
  out(at) = part;
  return out;
}

/// Moves from x towards `to` until the first free unknown is 0, and makes it bound.
void step_to_bound(const Eigen::VectorXd& to, std::vector<bool>& free, Eigen::VectorXd& x) {
  double step = 1;
  for (Eigen::Index i = 0; i < x.size(); ++i)
    if (free[static_cast<std::size_t>(i)] && to[i] <= 0) step = std::min(step, x[i] / (x[i] - to[i]));
  x += step * (to - x);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (!free[static_cast<std::size_t>(i)] || to[i] > 0 || x[i] > 1e-14) continue;
    free[static_cast<std::size_t>(i)] = false;
    x[i] = 0;
  }
}

}  // namespace

Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right) {
  // Unknowns of scale 1, so that one tolerance holds for all of them.
  const Eigen::VectorXd scale = gram.diagonal().cwiseSqrt().unaryExpr([](double s) { return s > 0 ? 1 / s : 0; });
  const Eigen::MatrixXd scaled = scale.asDiagonal() * gram * scale.asDiagonal();
  const Eigen::VectorXd b = scale.cwiseProduct(right);
  const double tolerance = 1e-12 * b.cwiseAbs().maxCoeff();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size());
  std::vector<bool> free(static_cast<std::size_t>(b.size()), false);
  const int most = 10 * static_cast<int>(b.size()) + 10;
  for (int round = 0; round < most; ++round) {
    Eigen::Index best = -1;
    const Eigen::VectorXd gradient = b - scaled * x;
    for (Eigen::Index i = 0; i < b.size(); ++i) {
      const bool candidate = !free[static_cast<std::size_t>(i)] && scale[i] > 0 && gradient[i] > tolerance;
      if (candidate && (best < 0 || gradient[i] > gradient[best])) best = i;
    }
    if (best < 0) break;
    free[static_cast<std::size_t>(best)] = true;
    Eigen::VectorXd next = solve_free(scaled, b, free);
    for (int inner = 0; inner < most; ++inner) {
      bool bound = false;
      for (Eigen::Index i = 0; i < b.size(); ++i) bound = bound || (free[static_cast<std::size_t>(i)] && next[i] <= 0);
      if (!bound) break;
      step_to_bound(next, free, x);
      next = solve_free(scaled, b, free);
    }
    x = next;
  }
  return scale.cwiseProduct(x);
}

}  // namespace reamsim
