// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

namespace reamsim {

/// A row of a table, with the JSON pointer of its value in summary.json.
struct SummaryLine {
  const char* pointer = nullptr;
  const char* label = nullptr;
  const char* unit = nullptr;
  const char* only_with = "";  ///< pointer of a value without which the row is left out
};

/// A table of values, without those that are missing; "" without any. Throws InputError, naming `path`, for values that
/// a run does not write.
std::string summary_table_html(const nlohmann::ordered_json& summary, const char* title,
                               std::span<const SummaryLine> lines, const std::string& path);

/// A column of a table with a row for each item of a list.
struct ListColumn {
  const char* key = nullptr;  ///< in the item
  const char* title = nullptr;
  int decimals = 1;  ///< kTextColumn: a text, of a path its last part
};
constexpr int kTextColumn = -1;

struct ListTable {
  const char* pointer;  ///< of the list in summary.json
  const char* title;
  const char* item;  ///< heads the column of the numbers, from 1
  std::span<const ListColumn> columns;
};

/// A row for each item, numbered as in the scenario; "" without any. Throws as summary_table_html().
std::string list_table_html(const nlohmann::ordered_json& summary, const ListTable& table, const std::string& path);

}  // namespace reamsim
