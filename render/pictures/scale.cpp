// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/pictures/scale.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

namespace reamsim {
/// Tolerance for rounding, so that 0.1 · 30 counts as 3.
static constexpr double kScaleTolerance = 1e-9;

double round_down(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value) + kScaleTolerance));
  const double lead = value / decade;
  return decade * (lead >= 5 - kScaleTolerance ? 5 : lead >= 2 - kScaleTolerance ? 2 : 1);
}

double round_up(double value) {
  const double below = round_down(value);
  if (below >= value * (1 - kScaleTolerance)) return below;
  const double decade = std::pow(10.0, std::floor(std::log10(below) + kScaleTolerance));
  const double lead = below / decade;
  return decade * (lead < 1.5 ? 2 : lead < 3 ? 5 : 10);
}

int Scale::ticks() const {
  return static_cast<int>(std::floor(max / step + 1e-6)) + 1;
}

std::string Scale::label(int tick) const {
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - kScaleTolerance)), 0, 6);
  return fmt::format("{:.{}f}", tick * step, decimals);
}

Scale scale_up_to(double max) {
  if (!(max > 0) || !std::isfinite(max)) return {1, 0.2};
  const double step = round_up(max / 8);
  return {step * std::ceil(max / step - 1e-6), step};
}

Scale scale_exactly(double max) {
  return {max, round_up(max / 8)};
}

}  // namespace reamsim
