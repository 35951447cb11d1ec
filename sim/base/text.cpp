// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>

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
  // Up to here doubles hold every integer.
  constexpr double kIntegers = 9007199254740992.0;
  char digits[32];
  const bool integer =
      std::abs(value) <= kIntegers && value == std::trunc(value) && !(value == 0 && std::signbit(value));
  const auto end = integer ? std::to_chars(digits, digits + sizeof digits, static_cast<std::int64_t>(value))
                           : std::to_chars(digits, digits + sizeof digits, value);
  return {digits, end.ptr};
}

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> out;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find(separator, begin);
    out.emplace_back(text.substr(begin, end - begin));
    if (end == std::string_view::npos) return out;
    begin = end + 1;
  }
}

bool is_whole_number(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

std::string megabytes(std::size_t bytes) {
  return std::to_string((bytes + 999'999) / 1'000'000) + " MB";
}

std::size_t text_width(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

std::vector<std::string> align_columns(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], text_width(row[i]));
  }
  std::vector<std::string> lines;
  for (const auto& row : rows) {
    std::string line = row[0] + std::string(widths[0] - text_width(row[0]), ' ');
    for (std::size_t i = 1; i < row.size(); ++i)
      line += "  " + std::string(widths[i] - text_width(row[i]), ' ') + row[i];
    lines.push_back(line);
  }
  return lines;
}

}  // namespace reamsim
