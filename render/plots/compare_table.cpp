// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/compare_table.h"

#include <algorithm>

#include "sim/base/text.h"

namespace reamsim {
namespace {

/// Most characters of a header, a cell and a label; longer ones are listed below the table.
constexpr std::size_t kMostInCell = 24;

using Rows = std::vector<std::vector<std::string>>;

/// The last `parts` parts of a dotted key.
std::string last_parts(const std::string& key, std::size_t parts) {
  std::size_t at = key.size();
  while (parts-- > 0 && at != std::string::npos && at > 0) at = key.rfind('.', at - 1);
  return at == std::string::npos || at == 0 ? key : key.substr(at + 1);
}

/// The fewest last parts of each key that tell it from the others.
std::vector<std::string> short_names(const std::vector<RunColumn>& columns) {
  std::vector<std::string> names;
  for (const RunColumn& column : columns) {
    std::size_t parts = 1;
    const auto is_shared = [&](const RunColumn& other) {
      return &other != &column && last_parts(other.key, parts) == last_parts(column.key, parts);
    };
    while (std::ranges::any_of(columns, is_shared) && last_parts(column.key, parts) != column.key) ++parts;
    names.push_back(last_parts(column.key, parts));
  }
  return names;
}

/// Long texts and what stands for them.
class Legend {
 public:
  /// `text`, or its number where it is long.
  std::string of(const std::string& text) {
    if (text_width(text) <= kMostInCell) return text;
    const auto found = std::ranges::find(texts_, text);
    if (found == texts_.end()) texts_.push_back(text);
    return mark(static_cast<std::size_t>(std::ranges::find(texts_, text) - texts_.begin()));
  }
  /// A line per text, wrapped.
  [[nodiscard]] std::vector<std::string> lines(std::size_t width) const {
    std::vector<std::string> out;
    for (std::size_t i = 0; i < texts_.size(); ++i) wrap(mark(i) + " " + texts_[i], width, out);
    return out;
  }

 private:
  static std::string mark(std::size_t number) { return "[" + std::to_string(number + 1) + "]"; }

  static void wrap(const std::string& text, std::size_t width, std::vector<std::string>& out) {
    std::string line;
    for (std::size_t at = 0; at < text.size();) {
      std::size_t end = at + 1;
      while (end < text.size() && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) ++end;
      if (text_width(line) == width) {
        out.push_back(line);
        line = "  ";
      }
      line += text.substr(at, end - at);
      at = end;
    }
    out.push_back(line);
  }

  std::vector<std::string> texts_;
};

std::size_t widest(const std::vector<std::string>& lines) {
  std::size_t out = 0;
  for (const std::string& line : lines) out = std::max(out, text_width(line));
  return out;
}

std::vector<std::string> row_per_column(const std::vector<std::string>& labels, const std::vector<RunColumn>& columns) {
  Rows rows{{"run"}};
  rows[0].insert(rows[0].end(), labels.begin(), labels.end());
  for (const RunColumn& column : columns) {
    rows.push_back({column.key});
    rows.back().insert(rows.back().end(), column.cells.begin(), column.cells.end());
  }
  return align_columns(rows);
}

/// Appends one block: the first columns of `rows` are number and label.
void add_block(const Rows& rows, std::vector<std::string>& out) {
  if (!out.empty()) out.emplace_back();
  const std::vector<std::string> lines = align_columns(rows);
  out.insert(out.end(), lines.begin(), lines.end());
}

std::vector<std::string> row_per_run(const std::vector<std::string>& labels, const std::vector<RunColumn>& columns,
                                     std::size_t width) {
  Legend legend;
  const std::vector<std::string> names = short_names(columns);
  Rows heads{{"run"}};
  const std::size_t digits = std::to_string(labels.size()).size();
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::string number = std::to_string(i + 1);
    heads.push_back({std::string(digits - number.size(), ' ') + number + " " + legend.of(labels[i])});
  }
  std::size_t label_width = 0;
  for (const auto& head : heads) label_width = std::max(label_width, text_width(head[0]));
  for (std::size_t i = 0; i < heads.size(); ++i) heads[i][0] += std::string(label_width - text_width(heads[i][0]), ' ');
  std::vector<std::string> out;
  Rows block = heads;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    Rows longer = block;
    longer[0].push_back(legend.of(names[c]));
    for (std::size_t i = 0; i < labels.size(); ++i) longer[i + 1].push_back(legend.of(columns[c].cells[i]));
    if (widest(align_columns(longer)) > width && block[0].size() > 1) {
      add_block(block, out);
      for (std::size_t i = 0; i < block.size(); ++i) block[i] = {heads[i][0], longer[i].back()};
    } else {
      block = longer;
    }
  }
  add_block(block, out);
  const std::vector<std::string> listed = legend.lines(width);
  if (!listed.empty()) out.emplace_back();
  out.insert(out.end(), listed.begin(), listed.end());
  return out;
}

}  // namespace

std::vector<std::string> run_table(const std::vector<std::string>& labels, const std::vector<RunColumn>& columns,
                                   std::size_t width) {
  std::vector<std::string> lines = row_per_column(labels, columns);
  return widest(lines) <= width ? lines : row_per_run(labels, columns, width);
}

}  // namespace reamsim
