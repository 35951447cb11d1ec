// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/plots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "sim/base/text.h"

namespace reamsim {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::StartsWith;

TEST(CompareTable, AFewRunsStandSideBySide) {
  EXPECT_THAT(run_table({"a", "b"}, {{"motion.plunge.depth_mm", {"1", "2.5"}}, {"removed_mm3", {"10", "-"}}}, 100),
              ElementsAre("run                      a    b", "motion.plunge.depth_mm   1  2.5",
                          "removed_mm3             10    -"));
}

TEST(CompareTable, ManyRunsHaveARowEachAndShortNames) {
  std::vector<std::string> labels, first, second;
  for (int i = 1; i <= 30; ++i) {
    labels.push_back("r" + std::to_string(i));
    first.push_back(std::to_string(i));
    second.push_back(std::to_string(2 * i));
  }
  const auto lines = run_table(labels, {{"motion.plunge.depth_mm", first}, {"headline.depth_mm", second}}, 100);
  ASSERT_EQ(lines.size(), 31u);
  EXPECT_EQ(lines[0], "run     plunge.depth_mm  headline.depth_mm") << "depth_mm alone would be two columns";
  EXPECT_EQ(lines[9], " 9 r9                 9                 18");
  EXPECT_EQ(lines[30], "30 r30               30                 60");
}

/// Every cell is found again, whole, in its row or in the list below.
TEST(CompareTable, NothingIsLostAndNoLineIsTooWide) {
  const std::string long_value(260, 'x');
  for (const std::size_t width : {40, 60, 100}) {
    std::vector<std::string> labels{"ä" + std::string(70, 'n'), "ß"};
    std::vector<RunColumn> columns;
    for (int c = 0; c < 25; ++c) {
      const std::string number = std::to_string(c);
      columns.push_back({"section.a_key_with_a_long_name_" + number, {"value " + number, "other " + number}});
    }
    columns.push_back({"long", {long_value, "short"}});
    const auto lines = run_table(labels, columns, width);
    std::string all, unwrapped;
    for (const std::string& line : lines) {
      EXPECT_LE(text_width(line), width) << line;
      all += line + "\n";
      unwrapped += line.starts_with("  ") ? line.substr(2) : line;
    }
    for (const RunColumn& column : columns) {
      EXPECT_NE(unwrapped.find(column.key.substr(column.key.find('.') + 1)), std::string::npos) << column.key;
      for (const std::string& cell : column.cells) EXPECT_NE(unwrapped.find(cell), std::string::npos) << cell;
    }
    for (const std::string& label : labels) EXPECT_NE(unwrapped.find(label), std::string::npos) << label;
    EXPECT_THAT(lines, Contains(StartsWith("[1] ä")));
  }
}

TEST(CompareTable, WithoutColumnsTheRunsAreListed) {
  EXPECT_THAT(run_table({"a", "b"}, {}, 100), ElementsAre("run  a  b"));
}

}  // namespace
}  // namespace reamsim
