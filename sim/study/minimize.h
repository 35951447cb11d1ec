// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cmath>

namespace reamsim {

/// The place of the least value of `f` between `low` and `high`: the best of a scan, refined by golden section.
template <class Function>
double minimize(const Function& f, double low, double high, int scan) {
  const double step = (high - low) / scan;
  int best = 0;
  double least = f(low);
  for (int i = 1; i <= scan; ++i) {
    const double value = f(low + i * step);
    if (value < least) {
      least = value;
      best = i;
    }
  }
  double a = std::max(low, low + (best - 1) * step), b = std::min(high, low + (best + 1) * step);
  const double ratio = 0.5 * (std::sqrt(5.0) - 1);
  double c = b - ratio * (b - a), d = a + ratio * (b - a);
  double at_c = f(c), at_d = f(d);
  while (b - a > 1e-9 * (high - low)) {
    if (at_c < at_d) {
      b = d;
      d = c;
      at_d = at_c;
      c = b - ratio * (b - a);
      at_c = f(c);
    } else {
      a = c;
      c = d;
      at_c = at_d;
      d = a + ratio * (b - a);
      at_d = f(d);
    }
  }
  return 0.5 * (a + b);
}

}  // namespace reamsim
