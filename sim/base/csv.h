#pragma once

#include <fstream>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/error.h"

namespace reamsim {

/// Reads the named columns of a CSV file with a header line, in any order, and skips the others.
class CsvReader {
 public:
  /// `expected` says what file this should be, for messages. Throws InputError: unreadable, a column missing.
  CsvReader(const std::string& path, std::span<const std::string_view> names, const std::string& expected);

  /// Reads the next row that is not empty into `values`, in the order of the names; false at the end. An empty cell is
  /// NaN in the column `may_be_empty`. Throws InputError with file and line: a cell missing or not a finite number.
  bool next(std::vector<double>& values, std::string_view may_be_empty = {});

  /// The location of the row read last.
  [[nodiscard]] SourceLocation where() const { return {path_, line_, 0}; }

 private:
  std::string path_;
  std::vector<std::string_view> names_;
  std::vector<std::size_t> places_;
  std::ifstream in_;
  int line_ = 1;
};

/// Writes a CSV file with a header line. Numbers have the fewest digits that read back to the same value, and
/// integers no exponent, so the same run gives the same bytes; NaN is an empty cell.
class CsvWriter {
 public:
  /// Throws RunError when the file cannot be created.
  CsvWriter(const std::string& path, const std::string& header);
  /// One value for each column. Throws RunError when it cannot be written.
  void row(std::span<const double> values);
  void row(std::initializer_list<double> values) { row(std::span(values.begin(), values.size())); }
  /// Throws RunError when something could not be written.
  void close();

 private:
  void check() const;

  std::string path_;
  std::ofstream out_;
  std::size_t columns_;
};

}  // namespace reamsim
