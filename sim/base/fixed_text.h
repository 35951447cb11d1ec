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

/// The reamer's travel into the bone, mm, as pictures name it: drawn back behind its first contact, it has no depth.
inline std::string depth_text(double depth_mm) {
  return depth_mm < 0 ? "lifted" : fixed_text(depth_mm, 2) + " mm";
}

}  // namespace reamsim
