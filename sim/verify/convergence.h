#pragma once

#include "sim/record/verification.h"

namespace reamsim::verify {

/// Errors below this are the rounding of fills (16 bits) and of positions (single precision), not of the method: they
/// do not say how it converges.
inline constexpr double kRoundingError = 1e-7;

/// Order p of an error that falls as step^p: the slope of log|error| over log step, by least squares over the levels
/// above kRoundingError. None with fewer than two of them.
std::optional<double> observed_order(const std::vector<Level>& levels);

/// The index of the finest of at least two levels, coarsest first, each step half of the one before. `formal_order`
/// caps the observed order, and stands in for it where the last three levels do not converge monotonically; then the
/// larger of their differences counts.
GridIndex grid_index(const std::vector<Level>& levels, double formal_order);

/// Order and index of a refinement whose levels are filled in. Plane clipping is of second order.
void finish(Refinement& refinement);

}  // namespace reamsim::verify
