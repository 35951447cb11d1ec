// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/study_plan.h"

#include <algorithm>
#include <utility>

#include "sim/base/csv.h"
#include "sim/base/text.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

bool names_input(const KeyNode& key) {
  return key.info.kind == KeyKind::text &&
         (key.info.text == TextKind::input_file || key.info.text == TextKind::input_path);
}

/// An empty cell leaves the value of the base scenario.
KeyValue value_of_cell(const std::string& key, const std::string& cell, const std::string& folder,
                       const SourceLocation& where) {
  const KeyNode& known = find_key(key, where);
  if (cell.empty() || !names_input(known)) return {cell, cell};
  return {cell, json_string(recorded_path(resolve_path(cell, known.info.text, folder, where, key)))};
}

constexpr std::string_view kLabel = "label";
constexpr std::size_t kMostRows = 1'000'000;
constexpr std::size_t kMostTableBytes = 1 << 30;

struct CsvLine {
  int number = 0;  ///< of its first line in the file
  std::vector<std::string> cells;
};

/// The lines of a CSV text (RFC 4180: quotes may hold commas, line ends and doubled quotes), without blank ones, which
/// spreadsheets leave below a table.
class CsvLines {
 public:
  CsvLines(const std::string& text, const std::string& file) : text_(text), file_(file) {}

  bool next(CsvLine& line) {
    while (at_ < text_.size()) {
      line = {.number = number_, .cells = {""}};
      read_cells(line);
      const auto is_blank = [](const std::string& cell) { return without_blanks(cell).empty(); };
      if (!std::ranges::all_of(line.cells, is_blank)) return true;
    }
    return false;
  }

 private:
  [[nodiscard]] bool precedes(char c) const { return at_ + 1 < text_.size() && text_[at_ + 1] == c; }

  void read_cells(CsvLine& line) {
    bool quoted = false;
    for (bool ended = false; at_ < text_.size() && !ended; ++at_) {
      const char c = text_[at_];
      std::string& cell = line.cells.back();
      if (c == '\n') ++number_;
      if (quoted && c == '"') {
        quoted = precedes('"');
        if (quoted) cell += text_[at_++];
      } else if (!quoted && c == ',') {
        line.cells.emplace_back();
      } else if (!quoted && c == '"' && cell.empty()) {
        quoted = true;
      } else if (!quoted && c == '\n') {
        ended = true;
      } else if (quoted || c != '\r' || !precedes('\n')) {
        cell += c;
      }
    }
    if (!quoted) return;
    throw InputError({file_, line.number, 0}, "", "a quotation mark that is not closed", "close it in the cell");
  }

  const std::string& text_;
  const std::string& file_;
  std::size_t at_ = 0;
  int number_ = 1;
};

/// The keys of the columns but kLabel.
std::vector<std::string> keys_of_header(const std::vector<std::string>& header, const SourceLocation& where) {
  std::vector<std::string> keys;
  if (header.size() == 1) refuse_other_separator(header[0], where);
  for (const std::string& cell : header) {
    const std::string name(without_blanks(cell));
    if (name.empty()) throw InputError(where, "", "a column without a name", "name a key of the scenario, or label");
    if (std::ranges::count(header, cell) > 1) throw InputError(where, name, "a column given twice", "keep one");
    if (name == kLabel) continue;
    // Also finds unknown keys, once instead of in each row.
    find_key(name, where);
    keys.push_back(name);
  }
  if (keys.empty()) throw InputError(where, "", "no column is a scenario key", "expected for example bone.ct.path");
  return keys;
}

void add_row(const std::vector<std::string>& header, const std::vector<std::string>& cells, const SourceLocation& where,
             const std::string& folder, CohortTable& table) {
  if (cells.size() != header.size()) {
    if (cells.size() == 1) refuse_other_separator(cells[0], where);
    throw InputError(where, "", "found " + std::to_string(cells.size()) + " cells",
                     "expected " + std::to_string(header.size()) + ", as in the header");
  }
  std::vector<KeyValue> level;
  MistakeList of_row;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string name(without_blanks(header[i])), cell(without_blanks(cells[i]));
    if (name == kLabel) {
      table.labels.push_back(cell);
    } else if (!of_row.attempt([&] { level.push_back(value_of_cell(name, cell, folder, where)); })) {
      level.push_back({.shown = cell, .applied = ""});
    }
  }
  table.mistakes.push_back(of_row.mistakes());
  table.levels.push_back(std::move(level));
  table.places.push_back(where.text());
}

}  // namespace

KeyValue value_of_node(const std::string& key, const YamlNode& node, const std::string& folder,
                       const SourceLocation& where) {
  const bool is_path = names_input(find_key(key, where)) && !node.text.empty();
  if (is_path) return value_of_cell(key, node.text, folder, where);
  const std::string applied = flow_text(node, true);
  return {node.kind == YamlNode::Kind::scalar ? node.text : applied, applied};
}

CohortTable read_cohort_table(const std::string& path, const std::string& folder, MistakeList& mistakes) {
  const std::string file = shown_path(path);
  std::string text = read_scenario_text(path, kMostTableBytes);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  CsvLines lines(text, file);
  CsvLine line;
  if (!lines.next(line)) refuse_file(file, "is empty", "expected a header line of scenario keys");
  const std::vector<std::string> header = line.cells;
  CohortTable table;
  table.keys = keys_of_header(header, {file, line.number, 0});
  while (lines.next(line)) {
    const SourceLocation where{file, line.number, 0};
    if (table.levels.size() >= kMostRows) throw InputError(where, "", "more than a million rows", "divide the study");
    mistakes.attempt([&] { add_row(header, line.cells, where, folder, table); });
  }
  if (table.levels.empty() && mistakes.empty())
    refuse_file(file, "has no rows", "expected a row per patient below the header");
  return table;
}

}  // namespace reamsim
