// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/mesh/mesh_io.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstring>
#include <optional>

#include "sim/base/error.h"

namespace reamsim {

std::vector<std::string> read_binary_stl(std::string_view bytes, const StlSink& sink) {
  std::vector<std::string> warnings;
  std::size_t count = stl_count(bytes);
  const std::size_t held = (bytes.size() - kStlHeaderBytes) / kStlTriangleBytes;
  if (is_unknown_stl_count(static_cast<std::uint32_t>(count))) {
    warnings.push_back("the header of the STL claims " + std::to_string(count) + " triangles; by its length it has " +
                       std::to_string(held) + ", and these are read");
    count = held;
  }
  count = std::min(count, held);
  const std::size_t rest = bytes.size() - kStlHeaderBytes - count * kStlTriangleBytes;
  if (rest > 0) {
    warnings.push_back("the header of the STL claims " + std::to_string(count) + " triangles; " + std::to_string(rest) +
                       " bytes after them are not read");
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::array<StlCorner, 3> corners{};
    constexpr std::size_t kNormalBytes = 12;
    std::memcpy(corners.data(), bytes.data() + kStlHeaderBytes + i * kStlTriangleBytes + kNormalBytes, sizeof corners);
    sink(corners);
  }
  return warnings;
}

namespace {

bool is_blank(char c) {
  return std::isspace(static_cast<unsigned char>(c)) != 0 || c == '\0';
}

class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
  }

  /// The next word; empty at the end.
  std::string_view next() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    begin_ = at_;
    while (at_ < text_.size() && !is_blank(text_[at_])) ++at_;
    return text_.substr(begin_, at_ - begin_);
  }
  void unread() { at_ = begin_; }
  void skip_line() { at_ = std::min(text_.find_first_of("\r\n", at_), text_.size()); }
  [[nodiscard]] bool line_ends() const {
    const std::size_t next = text_.find_first_not_of(" \t\f\v", at_);
    return next == std::string_view::npos || text_[next] == '\n' || text_[next] == '\r';
  }
  /// The line of the last word, from 1.
  [[nodiscard]] int line() const {
    int out = 1;
    for (std::size_t i = 0; i < begin_; ++i) {
      out += text_[i] == '\n' || (text_[i] == '\r' && (i + 1 == text_.size() || text_[i + 1] != '\n')) ? 1 : 0;
    }
    return out;
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t begin_ = 0;
};

/// Whether a word is `keyword`, which has small letters.
bool is(std::string_view word, std::string_view keyword) {
  return std::ranges::equal(word, keyword, {}, [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
}

class AsciiStl {
 public:
  AsciiStl(const std::string& path, std::string_view text, const StlSink& sink)
      : path_(path), words_(text), sink_(sink) {}

  std::vector<std::string> read() {
    bool open = false;
    for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) {
      if (is(word, "facet")) {
        read_facet();
      } else if (is(word, "solid") || is(word, "endsolid")) {
        open = is(word, "solid");
        skip_name();
      } else if (is(word, "end")) {
        open = false;  // "end solid"
        words_.skip_line();
      } else {
        words_.skip_line();
      }
    }
    std::vector<std::string> warnings;
    if (open) warnings.emplace_back("the STL ends without \"endsolid\": it may be truncated");
    if (decimal_comma_) warnings.emplace_back("the STL has decimal commas, which are read as decimal points");
    return warnings;
  }

 private:
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError({path_, words_.line(), 0}, "", found, expected);
  }

  /// A name reaches to the end of its line, or in a file without lines to the first facet.
  void skip_name() {
    while (!words_.line_ends()) {
      if (!is(words_.next(), "facet")) continue;
      Words after = words_;
      const std::string_view next = after.next();
      if (!is(next, "normal") && !is(next, "outer")) continue;
      words_.unread();
      return;
    }
  }

  void read_facet() {
    ++facets_;
    std::vector<StlCorner> corners;
    for (std::string_view word = words_.next();; word = words_.next()) {
      if (word.empty()) fail("a truncated STL: it ends within facet " + std::to_string(facets_), "export it again");
      if (is(word, "endfacet")) break;
      if (is(word, "end")) {  // "end facet"
        words_.next();
        break;
      }
      if (is(word, "facet") || is(word, "endsolid")) {  // without "endfacet"
        words_.unread();
        break;
      }
      if (is(word, "normal")) {
        skip_numbers();
      } else if (is(word, "loop")) {
        read_loop(corners);
      } else if (!is(word, "outer")) {
        words_.skip_line();  // a colour, for example
      }
    }
    if (corners.size() < 3) {
      fail("facet " + std::to_string(facets_) + " has " + std::to_string(corners.size()) + " vertices",
           "expected three");
    }
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) sink_({corners[0], corners[i], corners[i + 1]});
  }

  void read_loop(std::vector<StlCorner>& corners) {
    for (std::string_view word = words_.next(); !is(word, "endloop"); word = words_.next()) {
      if (word.empty()) fail("a truncated STL: it ends within facet " + std::to_string(facets_), "export it again");
      if (is(word, "end")) {  // "end loop"
        words_.next();
        return;
      }
      if (!is(word, "vertex")) fail("found " + shown(word) + " within a loop", "expected \"vertex\" or \"endloop\"");
      StlCorner& corner = corners.emplace_back();
      for (float& value : corner) {
        const std::string_view text = words_.next();
        const auto number = number_of(text);
        if (!number) fail("found " + shown(text) + " in a vertex", "expected three numbers");
        value = *number;
      }
    }
  }

  /// The three numbers of a normal, which is not used; some programs leave it out.
  void skip_numbers() {
    for (int i = 0; i < 3; ++i) {
      if (number_of(words_.next())) continue;
      words_.unread();
      return;
    }
  }

  static std::string shown(std::string_view word) {
    constexpr std::size_t kMost = 40;
    return word.empty() ? "the end of the file" : "\"" + std::string(word.substr(0, kMost)) + "\"";
  }

  /// Also "+1", "1,5" and "1.5D+02".
  std::optional<float> number_of(std::string_view word) {
    std::string text(word);
    if (text.starts_with('+')) text.erase(0, 1);
    for (char& c : text) {
      if (c == 'd' || c == 'D') c = 'e';
    }
    const std::size_t comma = text.find(',');
    if (comma != std::string::npos && text.find('.') == std::string::npos) text[comma] = '.';
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [stopped, error] = std::from_chars(text.data(), end, value);
    if (stopped != end || text.empty() || error == std::errc::invalid_argument) return std::nullopt;
    decimal_comma_ = decimal_comma_ || comma != std::string::npos;
    return static_cast<float>(value);
  }

  const std::string& path_;
  Words words_;
  const StlSink& sink_;
  std::size_t facets_ = 0;
  bool decimal_comma_ = false;
};

}  // namespace

std::vector<std::string> read_ascii_stl(const std::string& path, std::string_view text, const StlSink& sink) {
  return AsciiStl(path, text, sink).read();
}

}  // namespace reamsim
