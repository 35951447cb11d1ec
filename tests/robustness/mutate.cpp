// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "mutate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

namespace reamsim::test {

namespace {

/// Damage does most in the header.
constexpr std::size_t kHeaderBytes = 512;
constexpr std::size_t kTextHeaderBytes = 4096;

std::size_t below(Random& random, std::size_t limit) {
  return limit == 0 ? 0 : static_cast<std::size_t>(random() % limit);
}

std::size_t some_place(const std::string& bytes, Random& random) {
  const bool in_header = random() % 4 != 0;
  return below(random, in_header ? std::min(bytes.size(), kHeaderBytes) : bytes.size());
}

void change_bytes(std::string& bytes, Random& random) {
  for (std::size_t left = 1 + below(random, 8); left > 0 && !bytes.empty(); --left) {
    bytes[some_place(bytes, random)] = static_cast<char>(random());
  }
}

template <class T>
std::string bytes_of(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// A number at the end of a range, or none at all.
void put_number(std::string& bytes, Random& random) {
  const std::array<std::string, 16> numbers{bytes_of<std::int16_t>(-1),
                                            bytes_of<std::int16_t>(0),
                                            bytes_of<std::int16_t>(32767),
                                            bytes_of<std::int32_t>(0),
                                            bytes_of<std::int32_t>(-1),
                                            bytes_of<std::int32_t>(std::numeric_limits<std::int32_t>::max()),
                                            bytes_of<std::int32_t>(std::numeric_limits<std::int32_t>::min()),
                                            bytes_of<std::uint32_t>(65536),
                                            bytes_of<std::int64_t>(-1),
                                            bytes_of<std::int64_t>(std::numeric_limits<std::int64_t>::max()),
                                            bytes_of<float>(NAN),
                                            bytes_of<float>(INFINITY),
                                            bytes_of<float>(1.7e-7F),
                                            bytes_of<float>(1e30F),
                                            bytes_of<double>(NAN),
                                            bytes_of<double>(1e300)};
  const std::string& number = numbers[below(random, numbers.size())];
  if (bytes.size() < number.size()) return;
  std::size_t place = std::min(some_place(bytes, random), bytes.size() - number.size());
  if (random() % 2 == 0) place -= place % number.size() % (place + 1);  // where fields are aligned
  bytes.replace(place, number.size(), number);
}

void cut(std::string& bytes, Random& random) {
  bytes.resize(some_place(bytes, random));
}

void repeat_block(std::string& bytes, Random& random) {
  const std::size_t from = some_place(bytes, random);
  const std::string block = bytes.substr(from, 1 + below(random, 200));
  bytes.insert(some_place(bytes, random), block);
}

void remove_block(std::string& bytes, Random& random) {
  if (!bytes.empty()) bytes.erase(some_place(bytes, random), 1 + below(random, 200));
}

void insert_noise(std::string& bytes, Random& random) {
  std::string noise(1 + below(random, 64), '\0');
  for (char& c : noise) c = static_cast<char>(random());
  bytes.insert(some_place(bytes, random), noise);
}

/// Replaces a number in a line of text by one that no file should have.
std::string with_odd_number(const std::string& line, Random& random) {
  const std::array<const char*, 14> odd{
      "0",     "-1",  "1000000", "2147483647", "-2147483648", "99999999999999999999", "1e-7", "1.7e-7", "1e30",
      "1e999", "nan", "inf",     "",           "%s%n"};
  std::vector<std::size_t> digits;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] >= '0' && line[i] <= '9') digits.push_back(i);
  }
  const std::size_t at = digits.empty() ? below(random, line.size() + 1) : digits[below(random, digits.size())];
  std::size_t end = at;
  while (end < line.size() && line[end] >= '0' && line[end] <= '9') ++end;
  return line.substr(0, at) + odd[below(random, odd.size())] + line.substr(end);
}

void change_line(std::string& bytes, Random& random) {
  std::vector<std::size_t> starts{0};
  for (std::size_t i = 0; i + 1 < std::min(bytes.size(), kTextHeaderBytes); ++i) {
    if (bytes[i] == '\n') starts.push_back(i + 1);
  }
  const std::size_t n = below(random, starts.size());
  const std::size_t from = starts[n];
  const std::size_t end = std::min(bytes.find('\n', from), bytes.size());
  std::string line = bytes.substr(from, end - from);
  switch (random() % 6) {
    case 0:
      line = line + "\n" + line;
      break;
    case 1:
      line = "";
      break;
    case 2:
      line += std::string(2000, 'x');
      break;
    case 3:
      line += " " + line;
      break;
    default:
      line = with_odd_number(line, random);
  }
  bytes.replace(from, end - from, line);
}

/// Where a word, a number or a text in quotes begins and ends.
std::pair<std::size_t, std::size_t> some_token(const std::string& text, Random& random) {
  constexpr std::string_view kBetween = " \n\t,:[]{}";
  std::size_t from = below(random, text.size());
  while (from > 0 && kBetween.find(text[from - 1]) == std::string_view::npos) --from;
  return {from, std::min(text.find_first_of(kBetween, from), text.size())};
}

void change_token(std::string& text, Random& random) {
  static const std::vector<std::string> odd{"0",
                                            "-1",
                                            "1e308",
                                            "-1e308",
                                            "1e-308",
                                            "nan",
                                            ".inf",
                                            "-.inf",
                                            "null",
                                            "~",
                                            "true",
                                            "[]",
                                            "{}",
                                            "\"\"",
                                            "''",
                                            "*x",
                                            "&x 1",
                                            "<<",
                                            "!!binary x",
                                            "|",
                                            ">",
                                            "? a",
                                            "- 1",
                                            "a: b",
                                            "[1, 2]",
                                            "{a: 1}",
                                            "\"",
                                            "'",
                                            "\\",
                                            "2147483648",
                                            "9223372036854775808",
                                            "0x7fff",
                                            "1_000",
                                            "1,5",
                                            "\t",
                                            "\xEF\xBB\xBF",
                                            "\xC3\x28",
                                            "/dev/zero",
                                            "/",
                                            ".",
                                            "/proc/self/mem",
                                            "--- ",
                                            "...",
                                            "#",
                                            "%YAML 9.9"};
  const auto [from, end] = some_token(text, random);
  text.replace(from, end - from, odd[below(random, odd.size())]);
}

/// Replaces a value by one from elsewhere in the text.
void copy_token(std::string& text, Random& random) {
  const auto [from, end] = some_token(text, random);
  const std::string other = text.substr(from, end - from);
  const auto [to, to_end] = some_token(text, random);
  text.replace(to, to_end - to, other);
}

void nest_deeply(std::string& text, Random& random) {
  static const std::array<std::string, 5> open{"[", "{\"a\":", "{a: ", "- ", "\n "};
  const std::string& one = open[below(random, open.size())];
  std::string many;
  for (std::size_t left = std::size_t{10} << below(random, 15); left > 0; --left) many += one;
  text.insert(some_token(text, random).first, many);
}

void change_indentation(std::string& text, Random& random) {
  const std::size_t line = text.find('\n', below(random, text.size()));
  if (line == std::string::npos) return;
  if (random() % 2 == 0) {
    text.insert(line + 1, 1 + below(random, 4), ' ');
  } else {
    text.erase(line + 1, text.find_first_not_of(' ', line + 1) - line - 1);
  }
}

}  // namespace

std::string mutated_text(std::string text, Random& random) {
  constexpr std::array kWays{change_token, change_token, change_token,      copy_token,
                             copy_token,   nest_deeply,  change_indentation};
  if (random() % 3 == 0) return mutated(std::move(text), random);
  for (std::size_t left = 1 + below(random, 3); left > 0 && !text.empty(); --left) {
    kWays[below(random, kWays.size())](text, random);
  }
  return text;
}

std::string mutated(std::string bytes, Random& random) {
  constexpr std::array kWays{change_bytes, put_number,   cut,         repeat_block,
                             remove_block, insert_noise, change_line, change_line};
  for (std::size_t left = 1 + below(random, 3); left > 0; --left) {
    if (bytes.empty()) break;
    kWays[below(random, kWays.size())](bytes, random);
  }
  return bytes;
}

}  // namespace reamsim::test
