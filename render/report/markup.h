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

/// `page` with each {{name}} replaced, not recursively. Throws std::logic_error when a name has no text, because the
/// page is part of the program.
std::string fill_template(std::string_view page, const std::map<std::string, std::string>& texts);

}  // namespace reamsim
