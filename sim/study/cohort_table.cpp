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

}  // namespace

KeyValue value_of_node(const std::string& key, const YamlNode& node, const std::string& folder,
                       const SourceLocation& where) {
  const bool is_path = names_input(find_key(key, where)) && !node.text.empty();
  if (is_path) return value_of_cell(key, node.text, folder, where);
  const std::string applied = flow_text(node, true);
  return {node.kind == YamlNode::Kind::scalar ? node.text : applied, applied};
}

namespace {

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

class TableReader {
 public:
  TableReader(const std::string& path, const std::string& folder, MistakeList& mistakes)
      : file_(shown_path(path)), folder_(folder), mistakes_(mistakes) {}

  CohortTable read(std::string text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
    CsvLines lines(text, file_);
    CsvLine line;
    if (!lines.next(line)) refuse_file(file_, "is empty", "expected a header line of scenario keys");
    const CsvLine header = line;
    check_header(header);
    while (lines.next(line)) {
      if (table_.levels.size() >= kMostRows) {
        throw InputError({file_, line.number, 0}, "", "more than a million rows", "divide the study");
      }
      mistakes_.attempt([&] { add(header, line); });
    }
    if (table_.levels.empty() && mistakes_.empty())
      refuse_file(file_, "has no rows", "expected a row per patient below the header");
    return std::move(table_);
  }

 private:
  void check_header(const CsvLine& header) {
    const SourceLocation where{file_, header.number, 0};
    if (header.cells.size() == 1) refuse_other_separator(header.cells[0], where);
    for (const std::string& cell : header.cells) {
      const std::string name(without_blanks(cell));
      if (name.empty()) throw InputError(where, "", "a column without a name", "name a key of the scenario, or label");
      if (std::ranges::count(header.cells, cell) > 1) throw InputError(where, name, "a column given twice", "keep one");
      if (name == kLabel) continue;
      // Also finds unknown keys, once instead of in each row.
      find_key(name, where);
      table_.keys.push_back(name);
    }
    if (table_.keys.empty())
      throw InputError(where, "", "no column is a scenario key", "expected for example bone.ct.path");
  }

  void add(const CsvLine& header, const CsvLine& line) {
    const SourceLocation where{file_, line.number, 0};
    if (line.cells.size() != header.cells.size()) {
      if (line.cells.size() == 1) refuse_other_separator(line.cells[0], where);
      throw InputError(where, "", "found " + std::to_string(line.cells.size()) + " cells",
                       "expected " + std::to_string(header.cells.size()) + ", as in the header");
    }
    std::vector<KeyValue> level;
    std::vector<Mistake> of_row;
    for (std::size_t i = 0; i < line.cells.size(); ++i) {
      const std::string name(without_blanks(header.cells[i])), cell(without_blanks(line.cells[i]));
      if (name == kLabel) {
        table_.labels.push_back(cell);
        continue;
      }
      try {
        level.push_back(value_of_cell(name, cell, folder_, where));
      } catch (const InputError& error) {
        of_row.insert(of_row.end(), error.mistakes().begin(), error.mistakes().end());
        level.push_back({.shown = cell, .applied = ""});
      }
    }
    table_.mistakes.push_back(std::move(of_row));
    table_.levels.push_back(std::move(level));
    table_.places.push_back(file_ + ":" + std::to_string(line.number));
  }

  std::string file_;
  const std::string& folder_;
  MistakeList& mistakes_;
  CohortTable table_;
};

}  // namespace

CohortTable read_cohort_table(const std::string& path, const std::string& folder, MistakeList& mistakes) {
  return TableReader(path, folder, mistakes).read(read_scenario_text(path, kMostTableBytes));
}

}  // namespace reamsim
