#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

namespace reamsim {

/// A row of a table, with the JSON pointer of its value in summary.json.
struct SummaryLine {
  const char* pointer;
  const char* label;
  const char* unit;
  const char* only_with = "";  ///< pointer of a value without which the row is left out
};

/// A table of values, without those that are missing; "" without any. Throws InputError, naming `path`, for values that
/// a run does not write.
std::string summary_table_html(const nlohmann::ordered_json& summary, const char* title,
                               std::span<const SummaryLine> lines, const std::string& path);

}  // namespace reamsim
