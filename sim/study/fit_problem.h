// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim/study/fit_forces.h"

namespace reamsim {

/// The measured values against the parts of the basis, as cross products. The columns are P of each unit (grades that
/// share a specific energy), N of each, and the edge's Q_t and Q_n: what is measured is their sum with coefficients u,
/// k_n·u, K_t and K_n.
class FitProblem {
 public:
  FitProblem(const ForceBasis& basis, const std::vector<FrameTime>& frames, const MeasuredForces& measured,
             std::vector<std::vector<int>> units);

  [[nodiscard]] std::size_t units() const { return units_.size(); }
  [[nodiscard]] bool has_edge() const { return has_edge_; }
  [[nodiscard]] Eigen::Index columns() const { return columns_; }
  [[nodiscard]] std::size_t samples() const;

  /// Sets the weight of each channel to that of its residuals with these coefficients; nullptr: of its values.
  /// `floor`: least standard deviation relative to the RMS.
  void weigh(const Eigen::VectorXd* coefficients, double floor);
  /// Σ weights·(measured − fitted)².
  [[nodiscard]] double squares(const Eigen::VectorXd& coefficients) const;
  [[nodiscard]] const Eigen::MatrixXd& gram() const { return gram_; }
  [[nodiscard]] const Eigen::VectorXd& right() const { return right_; }
  [[nodiscard]] std::vector<ChannelResidual> residuals(const Eigen::VectorXd& coefficients) const;

 private:
  struct Channel {
    ForceChannel channel;
    std::size_t samples = 0;
    double sum = 0, squares = 0;  ///< of the measured values
    Eigen::MatrixXd gram;
    Eigen::VectorXd right;

    [[nodiscard]] double residual_squares(const Eigen::VectorXd& c) const {
      return std::max(0.0, squares - 2 * c.dot(right) + c.dot(gram * c));
    }
  };

  void add_sample(const Eigen::MatrixXd& parts, const MeasuredForces& measured, std::size_t at);
  [[nodiscard]] Eigen::MatrixXd parts_at(const ForceBasis& basis, const FrameTime& frame) const;

  std::vector<std::vector<int>> units_;
  std::vector<int> unit_of_grade_;
  bool has_edge_;
  Eigen::Index columns_;
  std::vector<Channel> channels_;
  Eigen::MatrixXd gram_;
  Eigen::VectorXd right_;
  double squares_ = 0;
};

}  // namespace reamsim
