#pragma once

#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <string>

namespace reamsim {

/// printf into a string of up to 511 bytes.
[[gnu::format(printf, 1, 2)]] inline std::string formatted(const char* pattern, ...) {
  std::array<char, 512> text;
  std::va_list values;
  va_start(values, pattern);
  std::vsnprintf(text.data(), text.size(), pattern, values);
  va_end(values);
  return text.data();
}

/// A number with `decimals`, never "-0.0".
inline std::string fixed_text(double value, int decimals) {
  const double step = std::pow(10.0, decimals);
  const double rounded = std::round(value * step) / step;
  return formatted("%.*f", decimals, rounded == 0 ? 0.0 : rounded);
}

/// The reamer's travel into the bone, mm, as pictures name it: drawn back behind its first contact, it has no depth.
inline std::string depth_text(double depth_mm) {
  return depth_mm < 0 ? "lifted" : fixed_text(depth_mm, 2) + " mm";
}

}  // namespace reamsim
