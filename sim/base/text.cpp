// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/text.h"

#include <fmt/core.h>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <regex>

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

std::string_view without_blanks(std::string_view text, std::string_view blanks) {
  const std::size_t first = text.find_first_not_of(blanks);
  return first == text.npos ? "" : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::string replace_all(std::string_view text, std::initializer_list<Replacement> replacements) {
  std::string out, begins;  // first characters of what is replaced
  out.reserve(text.size());
  for (const Replacement& one : replacements) begins += one.first.front();
  while (!text.empty()) {
    const auto here = [&](const Replacement& one) { return text.starts_with(one.first); };
    const auto found = std::ranges::find_if(replacements, here);
    const std::string_view kept = text.substr(0, text.find_first_of(begins, 1));
    out += found == replacements.end() ? kept : found->second;
    text.remove_prefix(found == replacements.end() ? kept.size() : found->first.size());
  }
  return out;
}

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
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

struct Pattern::Compiled {
  std::regex regex;
};

Pattern::Pattern(const std::string& expression) : compiled_(std::make_shared<Compiled>(std::regex(expression))) {}

bool Pattern::matches(const std::string& text) const {
  return std::regex_match(text, compiled_->regex);
}

namespace {

unsigned char byte_at(std::string_view text, std::size_t at) {
  return static_cast<unsigned char>(text[at]);
}

/// Whether a valid character of UTF-8 is a control character or controls the layout of a line.
bool is_control(std::string_view character) {
  const unsigned char first = byte_at(character, 0);
  if (character.size() == 1) return first < 0x20 || first == 0x7F;
  const unsigned char second = byte_at(character, 1);
  if (character.size() == 2) return first == 0xC2 && second < 0xA0;  // U+0080 to U+009F
  const unsigned char third = byte_at(character, 2);
  const bool line_or_override = second == 0x80 && third >= 0xA8 && third <= 0xAE;  // U+2028 to U+202E
  const bool isolate = second == 0x81 && third >= 0xA6 && third <= 0xA9;           // U+2066 to U+2069
  return character.size() == 3 && first == 0xE2 && (line_or_override || isolate);
}

}  // namespace

std::size_t utf8_length(std::string_view text, std::size_t at) {
  const unsigned char first = byte_at(text, at);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if (at + i >= text.size() || (byte_at(text, at + i) & 0xC0) != 0x80) return 0;
  }
  const unsigned char second = byte_at(text, at + 1);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool surrogate = first == 0xED && second > 0x9F;
  const bool beyond = first == 0xF4 && second > 0x8F;
  return overlong || surrogate || beyond ? 0 : length;
}

bool is_printable(std::string_view text) {
  return printable(text) == text;
}

std::string printable(std::string_view text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    if (length == 0 || is_control(text.substr(at, length))) {
      out += fmt::format("\\x{:02x}", byte_at(text, at));
      ++at;
    } else {
      out += text.substr(at, length);
      at += length;
    }
  }
  return out;
}

std::optional<std::uint64_t> whole_number(std::string_view text) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [read, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || read != end) return std::nullopt;
  return value;
}

}  // namespace reamsim
