// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include "render/report/markup.h"
#include "render/report/summary_table.h"
#include "sim/base/error.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;

/// A number with the decimals of its column, a text, or a dash for a missing value.
std::string cell_text(const Json& value, const ListColumn& column, const std::string& key, const std::string& path) {
  if (value.is_null()) return "–";
  const bool text_column = column.decimals == kTextColumn;
  if (!(text_column ? value.is_string() : value.is_number())) {
    throw InputError({path, 0}, key, "found another type", text_column ? "expected a text" : "expected a number");
  }
  if (!text_column) return fmt::format("{:.{}f}", value.get<double>(), column.decimals);
  const std::string text = value.get<std::string>();
  return escape_html(text.substr(text.rfind('/') + 1));
}

}  // namespace

std::string list_table_html(const Json& summary, const ListTable& table, const std::string& path) {
  const Json::json_pointer at(table.pointer);
  if (!summary.contains(at) || summary.at(at).empty()) return "";
  std::string out = std::string("<table>\n<caption>") + table.title + "</caption>\n<thead><tr><th scope=\"col\">" +
                    table.item + "</th>";
  for (const ListColumn& column : table.columns)
    out += std::string("<th scope=\"col\" style=\"text-align: right\">") + column.title + "</th>";
  out += "</tr></thead>\n<tbody>\n";
  int number = 0;
  for (const Json& item : summary.at(at)) {
    out += "<tr><th scope=\"row\">" + std::to_string(++number) + "</th>";
    for (const ListColumn& column : table.columns) {
      const Json value = item.is_object() && item.contains(column.key) ? item.at(column.key) : Json();
      out += "<td>" + cell_text(value, column, std::string(table.pointer) + "/" + column.key, path) + "</td>";
    }
    out += "</tr>\n";
  }
  return out + "</tbody>\n</table>\n";
}

}  // namespace reamsim
