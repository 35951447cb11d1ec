// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <fstream>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/error.h"

namespace reamsim {

struct CsvColumn {
  std::string name;        ///< in the header; of a column with a number: for messages
  std::size_t number = 0;  ///< from 1; 0: the column is found by its name
  bool may_be_missing = false;
};

struct CsvLayout {
  std::vector<CsvColumn> columns;
  char separator = ',';        ///< ' ': any number of blanks and tabulators
  bool decimal_comma = false;  ///< numbers have a comma for the point
  bool comments = false;       ///< lines that begin with # are skipped; one of them may be the header
  bool missing_cells = false;  ///< a cell that is empty, "nan" or "missing" is NaN
  bool killed_writer = false;  ///< a last line without its end, as SIGKILL leaves it, is skipped
  int skip_lines = 0;          ///< before the header
};

/// Reads columns of a CSV file, in any order, and skips the others. Takes what spreadsheets write: a byte order mark,
/// CRLF, blank lines, blanks and quotes around cells. Where a column has a name, the first line is the header; where
/// all have numbers, it is one if none of these columns has a number there.
class CsvReader {
 public:
  /// `expected` says what file this should be, for messages. Throws InputError: unreadable, larger than 4 GiB, empty, a
  /// column missing or given twice.
  CsvReader(const std::string& path, std::span<const std::string_view> names, const std::string& expected);
  /// The same for another layout.
  CsvReader(const std::string& path, CsvLayout layout, const std::string& expected);

  /// Reads the next row that is not blank into `values`, in the order of the names; false at the end. An empty cell is
  /// NaN in the column `may_be_empty`, and so is a column that is missing. Throws InputError with file and line: fewer
  /// or more cells than in the header, not a finite number, a line of more than 64 kB.
  bool next(std::vector<double>& values, std::string_view may_be_empty = {});

  [[nodiscard]] SourceLocation where() const { return {path_, line_, 0}; }
  [[nodiscard]] const std::vector<std::string>& skipped() const { return skipped_; }

 private:
  void open(const std::string& expected);
  void read_header(const std::string& expected);
  void find_columns(std::string_view header, const std::string& expected);
  /// Whether a comment is the header: it has all names.
  [[nodiscard]] bool is_header(std::string_view comment) const;
  /// Reads the next line that is not blank; it may be a comment.
  bool next_line();
  [[nodiscard]] double value_of(std::size_t column, std::string_view cell, std::string_view may_be_empty) const;

  std::string path_;
  CsvLayout layout_;
  std::vector<std::size_t> places_;
  std::vector<std::string> skipped_;
  std::size_t columns_ = 0;  ///< of the header, or of the first row
  bool has_header_ = true;
  bool pending_ = false;  ///< the line has been read to see that it is no header
  std::ifstream in_;
  std::string text_;
  int line_ = 0;
};

/// The header line of a file without its byte order mark. Throws InputError as refuse_other_separator().
std::string csv_header(std::string line, const SourceLocation& where);

/// Throws InputError where semicolons or tabulators instead of commas separate the cells of a line.
void refuse_other_separator(std::string_view line, const SourceLocation& where);

/// The cells of a line, without blanks and quotes around them. `separator`: see CsvLayout.
std::vector<std::string_view> csv_cells(std::string_view line, char separator = ',');

/// A text as a CSV cell, on one line and quoted where necessary (RFC 4180). A spreadsheet would take a text that begins
/// with =, +, - or @ for a formula, so an apostrophe precedes it.
std::string csv_text(std::string_view text);

/// A text as a quoted CSV cell, whatever it is.
std::string quoted_cell(std::string_view text);

/// Writes a CSV file with a header line. Numbers have the fewest digits that read back to the same value, and
/// integers no exponent, so the same run gives the same bytes; NaN is an empty cell. Each write() ends with a row, but
/// Linux may cut a write at the end of a page where SIGKILL meets it: see CsvLayout::killed_writer.
class CsvWriter {
 public:
  /// `bytes`: continues a file of so many bytes, by sync(), and removes what follows; 0: begins a new one. Throws
  /// RunError when it cannot be created, InputError where it is shorter.
  CsvWriter(const std::string& path, const std::string& header, std::uintmax_t bytes = 0);
  ~CsvWriter();
  CsvWriter(const CsvWriter&) = delete;
  CsvWriter& operator=(const CsvWriter&) = delete;

  /// One value for each column. Throws RunError when it cannot be written.
  void row(std::span<const double> values);
  void row(std::initializer_list<double> values) { row(std::span(values.begin(), values.size())); }
  /// Waits until all rows are on the disk. Returns the length of the file. Throws RunError.
  std::uintmax_t sync();
  /// Throws RunError when something could not be written.
  void close();

 private:
  void flush();
  /// Writes rows_; where that fails, the file ends with its last whole row.
  void write_rows();

  std::string path_;
  std::ofstream out_;
  std::size_t columns_;
  std::string rows_;                // not yet in the file
  std::uintmax_t whole_bytes_ = 0;  // of the file, with whole rows only
};

}  // namespace reamsim
