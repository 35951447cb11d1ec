#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

namespace reamsim {

/// A number with `decimals`, never "-0.0".
inline std::string fixed_text(double value, int decimals) {
  std::array<char, 64> text;
  const double step = std::pow(10.0, decimals);
  const double rounded = std::round(value * step) / step;
  std::snprintf(text.data(), text.size(), "%.*f", decimals, rounded == 0 ? 0.0 : rounded);
  return text.data();
}

}  // namespace reamsim
