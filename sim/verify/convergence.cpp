// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/verify/convergence.h"

#include <algorithm>
#include <cmath>

namespace reamsim::verify {

namespace {

constexpr double kRatio = 2;  // of one step to the next
constexpr double kFormalOrder = 2;
/// Below this observed order the levels are outside the asymptotic range.
constexpr double kLeastOrder = 0.5;
constexpr double kSafetyOfThree = 1.25, kSafetyOfTwo = 3;  // Roache

/// Order from three values alone, finest last; none where they do not converge monotonically.
std::optional<double> order_of_three(double coarse, double middle, double fine) {
  const double before = middle - coarse, after = fine - middle;
  if (before * after <= 0 || std::abs(after) >= std::abs(before)) return std::nullopt;
  const double order = std::log(before / after) / std::log(kRatio);
  return order < kLeastOrder ? std::nullopt : std::optional(order);
}

}  // namespace

std::optional<double> observed_order(const std::vector<Level>& levels) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const Level& level : levels) {
    if (!level.error || std::abs(*level.error) < kRoundingError) continue;
    const double x = std::log(level.step), y = std::log(std::abs(*level.error));
    n += 1;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  if (n < 2) return std::nullopt;
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

GridIndex grid_index(const std::vector<Level>& levels, double formal_order) {
  const std::size_t n = levels.size();
  const double fine = levels[n - 1].found, after = std::abs(fine - levels[n - 2].found);
  GridIndex out{.fraction = 0, .safety_factor = kSafetyOfTwo, .order = {}};
  double difference = after, order = formal_order;
  if (n >= 3) {
    difference = std::max(after, std::abs(levels[n - 2].found - levels[n - 3].found));
    out.order = order_of_three(levels[n - 3].found, levels[n - 2].found, fine);
  }
  if (out.order) {
    out.safety_factor = kSafetyOfThree;
    order = std::min(*out.order, formal_order);
    difference = after;
  }
  out.fraction = out.safety_factor * difference / (std::abs(fine) * (std::pow(kRatio, order) - 1));
  return out;
}

void finish(Refinement& refinement) {
  refinement.order = observed_order(refinement.levels);
  refinement.index = grid_index(refinement.levels, kFormalOrder);
}

}  // namespace reamsim::verify
