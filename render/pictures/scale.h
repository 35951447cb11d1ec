// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

namespace reamsim {

/// The largest of 1, 2, 5 × 10ⁿ that is not above `value` (> 0).
double round_down(double value);
/// The smallest of 1, 2, 5 × 10ⁿ that is not below `value` (> 0).
double round_up(double value);

/// Ticks of a legend or axis at 0, step, 2·step … max.
struct Scale {
  double max = 1;
  double step = 1;

  [[nodiscard]] int ticks() const;
  /// The label of a tick, with the decimals that the step needs.
  [[nodiscard]] std::string label(int tick) const;
};

/// A scale with four to eight steps that ends at `max` or just above it; 0…1 when `max` is not positive.
Scale scale_up_to(double max);
/// A scale that ends exactly at `max` (> 0); its last step may be shorter.
Scale scale_exactly(double max);

}  // namespace reamsim
