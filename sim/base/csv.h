#pragma once

#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/error.h"

namespace reamsim {

/// Reads wanted columns of a CSV with a header line, wherever they stand; others are passed over.
class CsvTable {
 public:
  /// `expected` says what file this should be, for messages. Throws InputError: unreadable, a column missing.
  CsvTable(const std::string& path, std::span<const std::string_view> names, std::string expected);

  /// Reads the next row that is not empty into `values`, in the order of the names; false at the end. An empty cell is
  /// NaN where its column's name is `may_be_empty`. Throws InputError with file and line: a cell missing or not a
  /// finite number.
  bool next(std::vector<double>& values, std::string_view may_be_empty = {});

  /// Where the row read last stands.
  [[nodiscard]] SourceLocation where() const { return {path_, line_, 0}; }

 private:
  std::string path_;
  std::vector<std::string_view> names_;
  std::vector<std::size_t> places_;
  std::ifstream in_;
  int line_ = 1;
};

}  // namespace reamsim
