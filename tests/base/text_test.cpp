// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "sim/base/csv.h"
#include "sim/base/text.h"

namespace reamsim::test {
namespace {

TEST(Printable, KeepsTextOfEveryLanguage) {
  for (const char* text : {"", "a b.yaml", "Glenoïd 関節窩 المفصل", "\"quotes\" 'and' <tags>"}) {
    EXPECT_TRUE(is_printable(text)) << text;
    EXPECT_EQ(printable(text), text);
  }
}

TEST(Printable, ShowsControlCharactersAndBrokenUtf8AsBytes) {
  const std::pair<const char*, const char*> cases[]{{"a\nb", "a\\x0ab"},
                                                    {"\x1b[31m", "\\x1b[31m"},
                                                    {"\x7f", "\\x7f"},
                                                    {"\xc2\x85", "\\xc2\\x85"},
                                                    {"\xff\xfe", "\\xff\\xfe"},
                                                    {"cut \xe2\x80", "cut \\xe2\\x80"},
                                                    {"\xe2\x80\xa8", "\\xe2\\x80\\xa8"},   // line separator
                                                    {"\xe2\x80\xae", "\\xe2\\x80\\xae"},   // right-to-left override
                                                    {"\xe2\x81\xa6", "\\xe2\\x81\\xa6"},   // isolate
                                                    {"\xed\xa0\x80", "\\xed\\xa0\\x80"}};  // surrogate
  for (const auto& [text, shown] : cases) {
    EXPECT_FALSE(is_printable(text)) << shown;
    EXPECT_EQ(printable(text), shown);
  }
}

TEST(Split, KeepsEmptyParts) {
  using Parts = std::vector<std::string>;
  EXPECT_EQ(split("a.b.0", '.'), (Parts{"a", "b", "0"}));
  EXPECT_EQ(split("", '.'), Parts{""});
  EXPECT_EQ(split(".a..", '.'), (Parts{"", "a", "", ""}));
}

TEST(IsWholeNumber, DigitsOnly) {
  EXPECT_TRUE(is_whole_number("007"));
  for (const char* text : {"", "-1", "1.0", "1 ", "x"}) EXPECT_FALSE(is_whole_number(text)) << text;
}

TEST(WholeNumber, SixtyFourBitsOfDigitsOnly) {
  EXPECT_EQ(whole_number("007"), 7U);
  EXPECT_EQ(whole_number("4294967297"), 4294967297U);
  EXPECT_EQ(whole_number("18446744073709551615"), std::numeric_limits<std::uint64_t>::max());
  for (const char* text : {"", "18446744073709551616", "-1", "+1", " 1", "1 ", "1.0", "x"}) {
    EXPECT_FALSE(whole_number(text).has_value()) << text;
  }
}

TEST(CsvText, QuotesAndNeverStartsAFormula) {
  EXPECT_EQ(csv_text("flat reamer"), "flat reamer");
  EXPECT_EQ(csv_text("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_text("say \"a\""), "\"say \"\"a\"\"\"");
  EXPECT_EQ(csv_text("two\nlines"), "two\\x0alines");
  for (const std::string first : {"=", "+", "-", "@"}) EXPECT_EQ(csv_text(first + "1"), "'" + first + "1");
  EXPECT_EQ(csv_text("=HYPERLINK(\"x\",\"y\")"), "\"'=HYPERLINK(\"\"x\"\",\"\"y\"\")\"");
}

}  // namespace
}  // namespace reamsim::test
