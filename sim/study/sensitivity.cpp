// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/sensitivity.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace reamsim {

namespace {

/// The outputs of a sample: rows samples, columns outputs.
Eigen::MatrixXd outputs_of(const Eigen::MatrixXd& inputs, const Model& model) {
  Eigen::MatrixXd out;
  for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
    const Eigen::VectorXd values = model(inputs.row(i).transpose());
    if (i == 0) out.resize(inputs.rows(), values.size());
    out.row(i) = values.transpose();
  }
  return out;
}

/// Half the width of the 95 % interval of mean(above)/mean(below), by the delta method.
double error_of_ratio(const Eigen::ArrayXd& above, const Eigen::ArrayXd& below) {
  constexpr double kQuantile = 1.96;  // 97.5 % of a normal distribution
  const auto count = static_cast<double>(above.size());
  const Eigen::ArrayXd deviation = above - above.mean() / below.mean() * below;
  return kQuantile * std::sqrt(deviation.square().sum() / (count * (count - 1))) / below.mean();
}

}  // namespace

std::vector<SobolIndices> sobol_indices(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, const Model& model) {
  if (a.rows() != b.rows() || a.cols() != b.cols() || a.rows() < 2)
    throw std::invalid_argument("sobol_indices: two samples of the same size are needed");
  const Eigen::MatrixXd of_a = outputs_of(a, model), of_b = outputs_of(b, model);
  const auto count = static_cast<double>(a.rows());
  // About the mean, because the estimators subtract large numbers otherwise.
  const Eigen::RowVectorXd mean = 0.5 * (of_a.colwise().mean() + of_b.colwise().mean());
  const Eigen::MatrixXd from_a = of_a.rowwise() - mean, from_b = of_b.rowwise() - mean;
  const Eigen::RowVectorXd variance =
      (from_a.colwise().squaredNorm() + from_b.colwise().squaredNorm()) / (2 * count - 1);
  std::vector<SobolIndices> out(static_cast<std::size_t>(of_a.cols()));
  for (Eigen::Index input = 0; input < a.cols(); ++input) {
    Eigen::MatrixXd mixed = a;
    mixed.col(input) = b.col(input);
    const Eigen::MatrixXd of_mixed = outputs_of(mixed, model).rowwise() - mean;
    for (Eigen::Index output = 0; output < of_a.cols(); ++output) {
      SobolIndices& to = out[static_cast<std::size_t>(output)];
      const double all = variance[output];
      const Eigen::ArrayXd y_a = from_a.col(output), y_b = from_b.col(output), y_mixed = of_mixed.col(output);
      const Eigen::ArrayXd alone = y_b * (y_mixed - y_a), rest = 0.5 * (y_a - y_mixed).square();
      const Eigen::ArrayXd squares = 0.5 * (y_a.square() + y_b.square());
      to.first.push_back(all > 0 ? alone.mean() / all : 0);
      to.total.push_back(all > 0 ? rest.mean() / all : 0);
      to.first_error.push_back(all > 0 ? error_of_ratio(alone, squares) : 0);
      to.total_error.push_back(all > 0 ? error_of_ratio(rest, squares) : 0);
      to.mean = mean[output];
      to.variance = all;
    }
  }
  return out;
}

std::string dominant_inputs(const SobolIndices& indices, const std::vector<std::string>& names) {
  if (!(indices.variance > 0)) return "the output does not vary";
  std::vector<std::size_t> order(names.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, std::greater(), [&](std::size_t i) { return indices.total[i]; });
  const auto part = [&](std::size_t i) {
    return fmt::format("{} ({:.0f} ± {:.0f} % of the variance alone, {:.0f} ± {:.0f} % in total)", names[i],
                       100 * indices.first[i], 100 * indices.first_error[i], 100 * indices.total[i],
                       100 * indices.total_error[i]);
  };
  constexpr double kMatters = 0.1;
  std::string out = part(order[0]) + " dominates";
  for (std::size_t i = 1; i < order.size() && indices.total[order[i]] >= kMatters; ++i)
    out += (i == 1 ? ", followed by " : ", ") + part(order[i]);
  return out;
}

}  // namespace reamsim
