#include "sim/bench/text_table.h"

#include <algorithm>

namespace reamsim::bench {

namespace {

/// Characters of UTF-8 text, not bytes.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

}  // namespace

std::string TextTable::text(const std::string& title) const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], width(row[c]));
  }
  std::string out = title + "\n";
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    std::string line = "  ";
    for (std::size_t c = 0; c < rows_[r].size(); ++c) {
      const std::string gap(widths[c] - width(rows_[r][c]), ' ');
      line += (c > 0 ? "  " : "") + (c == 0 ? rows_[r][c] + gap : gap + rows_[r][c]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
    if (r > 0) continue;
    std::size_t all = 0;
    for (const std::size_t w : widths) all += w + 2;
    out += "  " + std::string(all - 2, '-') + "\n";
  }
  return out + "\n";
}

}  // namespace reamsim::bench
