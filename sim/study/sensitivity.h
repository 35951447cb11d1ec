// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

namespace reamsim {

/// Fractions of the variance of an output (Sobol 2001). The first-order index of an input is what it explains alone,
/// its total index what remains unexplained without it. Both are 0 where the output does not vary. They are estimates:
/// that of an input that explains nearly all may exceed 1, and the first order may exceed the total.
struct SobolIndices {
  std::vector<double> first;
  std::vector<double> total;
  /// Half the widths of their 95 % intervals, as of independent samples; those of a Sobol sequence scatter less.
  std::vector<double> first_error;
  std::vector<double> total_error;
  double mean = 0;
  double variance = 0;
};

/// The outputs of a model for the values of its inputs.
using Model = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

/// The indices of each output from two independent samples of the inputs (rows: samples, columns: inputs), as two
/// halves of one Sobol sequence of twice the inputs give them. Calls the model rows·(inputs + 2) times, in order. First
/// order after Saltelli et al. (2010), eq. b of their Table 2; total after Jansen (1999), eq. f.
std::vector<SobolIndices> sobol_indices(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, const Model& model);

/// Says in a sentence which inputs dominate. `names`: of the inputs.
std::string dominant_inputs(const SobolIndices& indices, const std::vector<std::string>& names);

}  // namespace reamsim
