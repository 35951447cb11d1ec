// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/record/verification.h"

namespace reamsim::verify {

/// Errors below this are rounding of fills (16 bits) and positions (single precision). They do not show the convergence
/// of the method.
inline constexpr double kRoundingError = 1e-7;

/// Order p of an error that falls as step^p: the slope of log|error| over log step, by least squares over the levels
/// above kRoundingError. None with fewer than two of them.
std::optional<double> observed_order(const std::vector<Level>& levels);

/// The index of the finest of at least two levels, coarsest first; each step is half of the previous one.
/// `formal_order` caps the observed order. It replaces that where the last three levels do not converge monotonically;
/// then the larger of their differences counts.
GridIndex grid_index(const std::vector<Level>& levels, double formal_order);

/// Sets order and index from the levels. Plane clipping is of second order.
void finish(Refinement& refinement);

}  // namespace reamsim::verify
