// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/viewer/page.h"

#include <fmt/core.h>
#include <openssl/evp.h>
#include <zlib.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <vector>

#include "sim/base/text.h"

namespace reamsim {
namespace embedded {
extern const char* const scene_script;
}

std::string escape_html(std::string_view text) {
  return replace_all(text, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}, {"'", "&#39;"}});
}

std::string base64(std::span<const std::uint8_t> bytes) {
  std::string out(4 * ((bytes.size() + 2) / 3), '\0');
  // OpenSSL appends a zero, for which a std::string has room, and takes an int length.
  constexpr std::size_t kPiece = 3 << 20;
  for (std::size_t from = 0; from < bytes.size(); from += kPiece) {
    const auto piece = bytes.subspan(from, std::min(kPiece, bytes.size() - from));
    EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data() + from / 3 * 4), piece.data(),
                    static_cast<int>(piece.size()));
  }
  return out;
}

std::string compressed_base64(std::span<const std::uint8_t> bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::vector<std::uint8_t> packed(size);
  if (compress2(packed.data(), &size, bytes.data(), static_cast<uLong>(bytes.size()), Z_BEST_COMPRESSION) != Z_OK) {
    throw std::bad_alloc();  // the room suffices, so memory is all that can be missing
  }
  return base64({packed.data(), size});
}

std::string json_for_script(const nlohmann::ordered_json& json) {
  // In JSON "<" occurs only in strings, where an escape may replace it.
  const std::string text = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  return replace_all(text, {{"<", "\\u003c"}});
}

double short_number(double value) {
  return std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr);
}

std::string fill_template(std::string_view page, const PageTexts& texts) {
  std::string out;
  for (std::size_t at = 0;;) {
    const std::size_t open = page.find("{{", at);
    out += page.substr(at, open == std::string_view::npos ? open : open - at);
    if (open == std::string_view::npos) return out;
    const std::size_t close = page.find("}}", open);
    const std::string name(page.substr(open + 2, close - open - 2));
    const auto text = texts.find(name);
    if (close == std::string_view::npos || text == texts.end()) {
      throw std::logic_error("report page: nothing to put in for " + name);
    }
    out += text->second;
    at = close + 2;
  }
}

std::string self_contained_page(const char* page, const std::string& title, const std::string& program,
                                const nlohmann::ordered_json& data, PageTexts texts) {
  texts["title"] = escape_html(title);
  texts["program"] = escape_html(program);
  texts["scene"] = embedded::scene_script;
  texts["data"] = json_for_script(data);
  return fill_template(page, texts);
}

}  // namespace reamsim
