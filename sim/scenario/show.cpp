// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/show.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "sim/base/text.h"

namespace reamsim {

namespace {

constexpr std::size_t kShownBytes = 60;
constexpr std::size_t kShownPathBytes = 300;

/// printable(), with "..." where the text was cut after `limit` bytes.
std::string cleaned(std::string_view text, std::size_t limit) {
  const bool cut = text.size() > limit;
  if (cut) {
    std::size_t end = limit;
    while (end > 0 && (text[end] & 0xC0) == 0x80) --end;  // not in the middle of a character
    text = text.substr(0, end);
  }
  return printable(text) + (cut ? "..." : "");
}

/// Words that some YAML reader or other takes for something else than text.
bool is_reserved_word(std::string_view text) {
  static constexpr std::array kWords{"null", "true", "false", "yes", "no", "on", "off", "y", "n"};
  return std::ranges::find(kWords, lower_case(std::string(text))) != kWords.end();
}

/// Sections and keys that change no number of the results.
constexpr std::array kWithoutEffect{"version", "name", "output", "render"};

/// Adds every value below `node`; a list of plain values is one value.
void add_values(const YamlNode& node, const std::string& path, ScenarioValues& out) {
  const auto is_map = [](const YamlNodePtr& item) { return item->kind == YamlNode::Kind::map; };
  if (node.kind == YamlNode::Kind::map) {
    for (const YamlEntry& entry : node.entries) {
      const bool shown = !path.empty() || std::ranges::find(kWithoutEffect, entry.key) == kWithoutEffect.end();
      if (shown) add_values(*entry.value, path.empty() ? entry.key : path + "." + entry.key, out);
    }
  } else if (std::ranges::any_of(node.items, is_map)) {
    for (std::size_t i = 0; i < node.items.size(); ++i) add_values(*node.items[i], path + "." + std::to_string(i), out);
  } else {
    out.emplace_back(path, flow_text(node, false));
  }
}

}  // namespace

std::string shown_text(std::string_view text) {
  return "\"" + cleaned(text, kShownBytes) + "\"";
}

std::string shown_path(std::string_view path) {
  return cleaned(path, kShownPathBytes);
}

std::string shown_key(std::string_view key) {
  const bool plain = !key.empty() && key.size() <= kShownBytes && std::ranges::all_of(key, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
  return plain ? std::string(key) : shown_text(key);
}

std::string shown(const YamlNode& node) {
  if (node.kind == YamlNode::Kind::null) return "nothing";
  if (node.kind == YamlNode::Kind::sequence) return "a list of " + std::to_string(node.items.size());
  if (node.kind == YamlNode::Kind::map) return "a section of keys";
  const bool word = !node.quoted && (parse_number(node.text) || node.text == "true" || node.text == "false");
  return word && node.text.size() <= kShownBytes ? node.text : "the text " + shown_text(node.text);
}

std::string flow_text(const YamlNode& node, bool quotes) {
  if (node.kind == YamlNode::Kind::null) return "null";
  if (node.kind == YamlNode::Kind::scalar) return quotes && node.quoted ? json_string(node.text) : node.text;
  std::string out;
  for (const YamlNodePtr& item : node.items) out += (out.empty() ? "" : ", ") + flow_text(*item, quotes);
  for (const YamlEntry& entry : node.entries) {
    out += (out.empty() ? "" : ", ") + yaml_scalar(entry.key) + ": " + flow_text(*entry.value, quotes);
  }
  return node.kind == YamlNode::Kind::sequence ? "[" + out + "]" : "{" + out + "}";
}

std::string number_text(double value) {
  std::array<char, 64> buffer{};
  // Fixed notation where people would use it; both are the shortest that read back.
  const double size = std::abs(value);
  const bool fixed = value == 0 || (size >= 1e-6 && size < 1e15);
  const auto format = fixed ? std::chars_format::fixed : std::chars_format::scientific;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, format).ptr;
  std::string out(buffer.data(), end);
  const auto exponent = out.find('e');
  if (exponent != std::string::npos && out.find('.') == std::string::npos) out.insert(exponent, ".0");
  return out;
}

std::string vector_text(const Vec3& v) {
  return "[" + number_text(v.x()) + ", " + number_text(v.y()) + ", " + number_text(v.z()) + "]";
}

std::optional<double> parse_number(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  const double sign = negative ? -1 : 1;
  if (text == ".inf" || text == ".Inf" || text == ".INF" || text == "inf" || text == "Inf" || text == "infinity") {
    return sign * std::numeric_limits<double>::infinity();
  }
  if (text == ".nan" || text == ".NaN" || text == ".NAN" || text == "nan" || text == "NaN" || text == "NAN") {
    return std::numeric_limits<double>::quiet_NaN();
  }
  if (text.empty() || std::string_view(".0123456789").find(text[0]) == text.npos) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || error == std::errc::invalid_argument) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    // Too large or too small for a double: from_chars does not say which; the exponent's sign does.
    return text.find("e-") != text.npos || text.find("E-") != text.npos
               ? 0.0
               : sign * std::numeric_limits<double>::infinity();
  }
  return sign * value;
}

std::string json_string(std::string_view text) {
  return nlohmann::json(std::string(text)).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string yaml_scalar(std::string_view text) {
  static const std::string kFirst = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ/_";
  static const std::string kAny = kFirst + "0123456789.-+ ()";
  const bool plain = !text.empty() && kFirst.find(text[0]) != kFirst.npos && text.back() != ' ' &&
                     text.find_first_not_of(kAny) == text.npos && !is_reserved_word(text);
  return plain ? std::string(text) : json_string(text);
}

ScenarioValues values_of_scenario(const YamlNode& document) {
  ScenarioValues out;
  add_values(document, "", out);
  return out;
}

}  // namespace reamsim
