// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Core>

namespace reamsim {

/// The x ≥ 0 that minimizes xᵀGx − 2·bᵀx, where G = AᵀA and b = Aᵀy of a least-squares problem: the active-set method
/// of Lawson and Hanson (1974) in the form of Bro and de Jong (1997), which needs G and b only.
Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right);

}  // namespace reamsim
