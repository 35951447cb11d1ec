// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace reamsim {

/// A number with `decimals`, never "-0.0".
std::string fixed_text(double value, int decimals);

/// The tool depth in pictures: "1.25 mm", or "lifted" above the first contact.
std::string depth_text(double depth_mm);

/// At most six significant digits: "0.25", "1e+07", "nan".
std::string rounded_text(double value);

/// The fewest digits that read back to the same value. Integers up to 2⁵³ have no exponent: "100000", not "1e+05".
std::string shortest_text(double value);

std::size_t text_width(const std::string& text);

/// The lines of a table: the first column left-aligned, the others right-aligned. No row is longer than the first.
std::vector<std::string> align_columns(const std::vector<std::vector<std::string>>& rows);

/// The parts of a text between separators, empty ones too: at least one.
std::vector<std::string> split(std::string_view text, char separator);

/// A text without these characters around it.
std::string_view without_blanks(std::string_view text, std::string_view blanks = " \t");

/// A text, and what replaces it.
using Replacement = std::pair<std::string_view, std::string_view>;

/// `text` with every replacement, from left to right, without those in what has been put in.
std::string replace_all(std::string_view text, std::initializer_list<Replacement> replacements);

/// A to Z as a to z.
std::string lower_case(std::string text);

/// Whether a text consists of digits: an index, a label.
bool is_whole_number(std::string_view text);

/// Whole megabytes, 10⁶ bytes, rounded up: "12 MB".
std::string megabytes(std::size_t bytes);

/// A regular expression in ECMAScript's grammar. A class of its own because std::regex takes seconds to compile in each
/// file that uses it. Throws std::regex_error.
class Pattern {
 public:
  explicit Pattern(const std::string& expression);

  [[nodiscard]] bool matches(const std::string& text) const;

 private:
  struct Compiled;
  std::shared_ptr<const Compiled> compiled_;
};

/// Bytes of the UTF-8 character at `text[at]`, 1 to 4, or 0 for an invalid one (stray, overlong, surrogate, cut off).
std::size_t utf8_length(std::string_view text, std::size_t at);

/// Whether a text is valid UTF-8 on one line: no control characters, line separators or changes of the writing
/// direction, with which a name could pass for something else on a terminal.
bool is_printable(std::string_view text);

/// `text` with every byte that is_printable() excludes as `\xNN`.
std::string printable(std::string_view text);

/// The number that a text of digits is; nothing where it is another text or the number has more than 64 bits.
std::optional<std::uint64_t> whole_number(std::string_view text);

}  // namespace reamsim
