#include "sim/base/text.h"

#include <fmt/core.h>
#include <charconv>
#include <cmath>

namespace reamsim {

std::string fixed_text(double value, int decimals) {
  const double step = std::pow(10.0, decimals);
  const double rounded = std::round(value * step) / step;
  return fmt::format("{:.{}f}", rounded == 0 ? 0.0 : rounded, decimals);
}

std::string depth_text(double depth_mm) {
  return depth_mm < 0 ? "lifted" : fixed_text(depth_mm, 2) + " mm";
}

std::string rounded_text(double value) {
  return fmt::format("{:.6g}", value);
}

std::string shortest_text(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

std::string megabytes(std::size_t bytes) {
  return std::to_string((bytes + 999'999) / 1'000'000) + " MB";
}

}  // namespace reamsim
