#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

namespace reamsim {

/// Text as it may stand in HTML, between tags and in quoted attributes.
std::string escape_html(std::string_view text);

/// Bytes in base 64 (RFC 4648, padded).
std::string base64(std::span<const std::uint8_t> bytes);

/// Bytes packed by zlib (RFC 1950), in base 64.
std::string packed_base64(std::span<const std::uint8_t> bytes);

/// JSON as it may stand in a <script> element: no character in it can end the element or open a comment. Text that is
/// not UTF-8 has its wrong bytes replaced.
std::string json_for_script(const nlohmann::ordered_json& json);

/// A value with at most six significant digits, which keeps its JSON short.
double short_number(double value);

/// `page` with every {{name}} replaced; what is put in is not looked at again. Throws std::logic_error when a name has
/// no text, because the page is part of the program.
std::string fill_page(std::string_view page, const std::map<std::string, std::string>& texts);

}  // namespace reamsim
