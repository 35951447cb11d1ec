// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "render/report/page_data.h"

namespace reamsim {
namespace {

/// Groups digits by thin spaces: 12345.6 → 12 345.6.
std::string with_thousands(std::string text) {
  const std::size_t point = std::min(text.find('.'), text.size());
  const std::size_t first = text.front() == '-' ? 1 : 0;
  if (point - first < 5) return text;
  for (std::size_t at = point; at > first + 3;) text.insert(at -= 3, "\u2009");
  return text;
}

double rounded(double value, int decimals) {
  const double step = std::pow(10.0, decimals);
  return std::round(value * step) / step;
}

std::string raised(int exponent) {
  static const std::array<const char*, 10> digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out = exponent < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(exponent))) out += digits[static_cast<std::size_t>(c - '0')];
  return out;
}

int exponent_of(double value) {
  return static_cast<int>(std::floor(std::log10(std::abs(value))));
}

/// 0.25 stays 0.25, but 28.996 becomes 29.00, where the zeros are significant.
int without_zeros(double value, int decimals) {
  while (decimals > 0 && std::abs(value - rounded(value, decimals - 1)) < 1e-9 * std::abs(value)) --decimals;
  return decimals;
}

std::string with_true_minus(std::string text) {
  if (text.front() == '-') text.replace(0, 1, "−");
  return text;
}

/// Decimals that mean something for a quantity of a reamed bone, by its unit; −1: unknown.
int decimals_of(std::string_view unit) {
  struct Decimals {
    std::string_view unit;
    int decimals;
  };
  static constexpr std::array kUnits{Decimals{"mm", 2},   Decimals{"mm²", 1}, Decimals{"mm³", 1},  Decimals{"N", 1},
                                     Decimals{"N·mm", 0}, Decimals{"mJ", 0},  Decimals{"°", 1},    Decimals{"%", 1},
                                     Decimals{"s", 3},    Decimals{"HU", 0},  Decimals{"g/cm³", 2}};
  const auto found = std::ranges::find(kUnits, unit, &Decimals::unit);
  return found == kUnits.end() ? -1 : found->decimals;
}

}  // namespace

std::string number_text(double value, int digits) {
  if (value == 0) return "0";
  if (!std::isfinite(value)) return "–";
  const std::string scientific = fmt::format("{:.{}e}", value, digits - 1);
  const int exponent = std::stoi(scientific.substr(scientific.find('e') + 1));
  std::string out;
  if (exponent < -4) {
    out = fmt::format("{:.1f} × 10", value / std::pow(10.0, exponent)) + raised(exponent);
  } else {
    const int decimals = without_zeros(value, std::max(0, digits - 1 - exponent));
    out = with_thousands(fmt::format("{:.{}f}", value, decimals));
  }
  return with_true_minus(out);
}

std::string measured_text(double value, const char* unit) {
  constexpr int kDigits = 4;
  int decimals = decimals_of(unit);
  if (decimals < 0) return number_text(value, kDigits - 1);
  if (value == 0 || !std::isfinite(value)) return number_text(value);
  if (std::abs(value) < 10 * std::pow(10.0, -decimals)) ++decimals;  // two digits of a small value
  decimals = std::min(decimals, std::max(0, kDigits - 1 - exponent_of(value)));
  const double step = std::pow(10.0, -decimals);
  if (value > 0 && value < 0.5 * step) return fmt::format("< {:.{}f}", step, decimals);
  const double shown = rounded(value, decimals);
  if (shown == 0) return fmt::format("{:.{}f}", 0.0, decimals);
  return with_true_minus(with_thousands(fmt::format("{:.{}f}", shown, without_zeros(value, decimals))));
}

}  // namespace reamsim
