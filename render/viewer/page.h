// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

namespace reamsim {

/// Text escaped for HTML, between tags and in quoted attributes.
std::string escape_html(std::string_view text);

/// Bytes in base 64 (RFC 4648, padded).
std::string base64(std::span<const std::uint8_t> bytes);

/// Bytes compressed by zlib (RFC 1950), in base 64.
std::string compressed_base64(std::span<const std::uint8_t> bytes);

/// JSON escaped for an element `script`: it cannot end the element or open a comment. Invalid UTF-8 is replaced.
std::string json_for_script(const nlohmann::ordered_json& json);

/// A value rounded to six significant digits, for short JSON.
double short_number(double value);

/// x, y, z with six significant digits.
template <class Vector>
nlohmann::ordered_json vector_json(const Vector& v) {
  return {short_number(v.x()), short_number(v.y()), short_number(v.z())};
}
/// Lower and upper corner of a box.
template <class Vector>
nlohmann::ordered_json box_json(const Vector& low, const Vector& high) {
  return nlohmann::ordered_json::array({vector_json(low), vector_json(high)});
}

using PageTexts = std::map<std::string, std::string>;

/// The pages of dist/, which build.mjs makes.
namespace embedded {
extern const char* const report_page;
extern const char* const preview_page;
extern const char* const study_page;
}  // namespace embedded

/// One of these pages as one HTML file that loads nothing: with its title, the name of the program, the data of its
/// scripts, and the `texts` (HTML) that it has other names for.
std::string self_contained_page(const char* page, const std::string& title, const std::string& program,
                                const nlohmann::ordered_json& data, PageTexts texts = {});

/// `page` with each {{name}} replaced, not recursively. Throws std::logic_error when a name has no text, because the
/// page is part of the program.
std::string fill_template(std::string_view page, const PageTexts& texts);

/// The page of a study: HTML without network, at most `most_bytes`, which sorts, filters and plots its runs and opens
/// their reports. A study that would be larger has a part of its runs, drawn at random; the page says so.
std::string study_page(const std::string& study, const struct RunTable& table, std::size_t most_bytes = 14'500'000);

}  // namespace reamsim
