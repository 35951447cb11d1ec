// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/csv.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "sim/base/file.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

constexpr std::size_t kBufferBytes = 1 << 16;
constexpr std::size_t kMissing = std::numeric_limits<std::size_t>::max();  // place of a column
constexpr std::uintmax_t kMostBytes = std::uintmax_t{4} << 30;
constexpr std::size_t kMostLine = 1 << 16;  // so that a binary file is not read into memory
constexpr std::string_view kBlank = " \t\r";

/// The number that a cell is, infinite or NaN where written so.
std::optional<double> number_of(std::string_view cell, bool decimal_comma) {
  std::string with_point;
  if (decimal_comma) {
    with_point = cell;
    std::ranges::replace(with_point, '.', '?');  // a point would separate thousands, or be a mistake
    std::ranges::replace(with_point, ',', '.');
    cell = with_point;
  }
  if (cell.starts_with('+')) cell.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  return value;
}

/// What trackers write where they have lost sight.
bool is_missing(std::string_view cell) {
  const std::string word = lower_case(std::string(cell));
  return word.empty() || word == "nan" || word == "missing";
}

CsvLayout layout_of(std::span<const std::string_view> names) {
  CsvLayout out;
  for (const std::string_view name : names) out.columns.push_back({.name = std::string(name)});
  return out;
}

}  // namespace

std::string csv_header(std::string line, const SourceLocation& where) {
  if (line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
  refuse_other_separator(line, where);
  return line;
}

void refuse_other_separator(std::string_view line, const SourceLocation& where) {
  if (line.find(',') != std::string_view::npos) return;
  const bool semicolons = line.find(';') != std::string_view::npos;
  if (!semicolons && line.find('\t') == std::string_view::npos) return;
  throw InputError(where, "", semicolons ? "semicolons separate the columns" : "tabulators separate the columns",
                   "save it with commas between columns and points in numbers, such as \"CSV UTF-8\"");
}

std::vector<std::string_view> csv_cells(std::string_view line, char separator) {
  const bool blanks = separator == ' ';
  std::vector<std::string_view> cells;
  for (;;) {
    if (blanks) line = without_blanks(line, kBlank);
    if (blanks && line.empty()) return cells;
    const std::size_t comma = blanks ? line.find_first_of(kBlank) : line.find(separator);
    std::string_view cell = without_blanks(line.substr(0, comma), kBlank);
    if (!blanks && cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
      cell = cell.substr(1, cell.size() - 2);
    cells.push_back(cell);
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

CsvReader::CsvReader(const std::string& path, std::span<const std::string_view> names, const std::string& expected)
    : CsvReader(path, layout_of(names), expected) {}

CsvReader::CsvReader(const std::string& path, CsvLayout layout, const std::string& expected)
    : path_(path), layout_(std::move(layout)) {
  open(expected);
  for (int i = 0; i < layout_.skip_lines && in_; ++i) {
    in_.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    ++line_;
  }
  read_header(expected);
}

void CsvReader::read_header(const std::string& expected) {
  const auto by_name = [](const CsvColumn& column) { return column.number == 0 && !column.may_be_missing; };
  has_header_ = std::ranges::any_of(layout_.columns, by_name);
  do {
    if (!next_line()) refuse_file(path_, "is empty", expected);
    if (has_header_ && is_header(text_)) return find_columns(without_blanks(text_, kBlank).substr(1), expected);
  } while (layout_.comments && without_blanks(text_, kBlank).starts_with('#'));
  find_columns(text_, expected);
}

bool CsvReader::is_header(std::string_view comment) const {
  comment = without_blanks(comment, kBlank);
  if (!layout_.comments || !comment.starts_with('#')) return false;
  const auto cells = csv_cells(comment.substr(1), layout_.separator);
  return std::ranges::all_of(layout_.columns, [&](const CsvColumn& column) {
    return column.number > 0 || column.may_be_missing || std::ranges::find(cells, column.name) != cells.end();
  });
}

void CsvReader::open(const std::string& expected) {
  std::error_code failed;
  const auto status = std::filesystem::status(path_, failed);
  if (failed || !std::filesystem::exists(status)) refuse_file(path_, "cannot be read: no such file", expected);
  if (std::filesystem::is_directory(status)) refuse_file(path_, "cannot be read: it is a folder", expected);
  if (const auto bytes = std::filesystem::file_size(path_, failed); !failed && bytes > kMostBytes)
    refuse_file(path_, "is larger than 4 GiB", expected);
  in_.open(path_, std::ios::binary);
  if (!in_) refuse_file(path_, "cannot be read", expected);
}

void CsvReader::find_columns(std::string_view header, const std::string& expected) {
  if (layout_.separator == ',') refuse_other_separator(header, where());
  const auto found = csv_cells(header, layout_.separator);
  columns_ = found.size();
  std::vector<bool> used(columns_);
  for (CsvColumn& column : layout_.columns) {
    if (column.number > columns_) {
      throw InputError(where(), "",
                       "found " + std::to_string(columns_) + " columns, and no column " + std::to_string(column.number),
                       expected);
    }
    auto at = found.end();
    if (column.number > 0) at = found.begin() + static_cast<std::ptrdiff_t>(column.number - 1);
    if (column.number == 0 && has_header_) at = std::ranges::find(found, column.name);
    const bool missing = at == found.end();
    if (missing && !column.may_be_missing)
      throw InputError(where(), printable(column.name), "no such column", expected);
    if (!missing && column.number == 0 && std::find(at + 1, found.end(), column.name) != found.end())
      throw InputError(where(), printable(column.name), "the column is given twice", "give each column once");
    places_.push_back(missing ? kMissing : static_cast<std::size_t>(at - found.begin()));
    if (!missing) used[places_.back()] = true;
  }
  if (!has_header_) {
    const auto is_text = [&](std::size_t place) {
      return place == kMissing || !number_of(found[place], layout_.decimal_comma);
    };
    has_header_ = std::ranges::all_of(places_, is_text);
    pending_ = !has_header_;
  }
  for (std::size_t i = 0; has_header_ && i < columns_; ++i) {
    if (!used[i]) skipped_.emplace_back(found[i]);
  }
}

bool CsvReader::next_line() {
  std::array<char, kMostLine> buffer;
  do {
    in_.getline(buffer.data(), buffer.size());
    // getline() also swallows exceptions of the memory.
    if (in_.bad()) throw RunError(path_ + ": cannot be read to its end; is the disk damaged, or the memory exhausted?");
    if (in_.eof() && (in_.gcount() == 0 || layout_.killed_writer)) return false;
    ++line_;
    if (in_.fail() && !in_.eof())
      throw InputError(where(), "", "a line of more than " + std::to_string(kMostLine - 1) + " bytes",
                       "is this a CSV file?");
    const auto got = static_cast<std::size_t>(in_.gcount());
    text_.assign(buffer.data(), in_.eof() ? got : got - 1);
    if (line_ == 1 && text_.starts_with("\xEF\xBB\xBF")) text_.erase(0, 3);
  } while (without_blanks(text_, kBlank).empty());
  return true;
}

double CsvReader::value_of(std::size_t column, std::string_view cell, std::string_view may_be_empty) const {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const std::string& name = layout_.columns[column].name;
  if (cell.empty() && name == may_be_empty) return kNone;
  if (layout_.missing_cells && is_missing(cell)) return kNone;
  const std::optional<double> value = number_of(cell, layout_.decimal_comma);
  if (value && std::isfinite(*value)) return *value;
  throw InputError(where(), printable(name), "found '" + printable(cell.substr(0, 40)) + "'",
                   std::string("expected a finite number") + (layout_.decimal_comma ? " with a decimal comma" : ""));
}

bool CsvReader::next(std::vector<double>& values, std::string_view may_be_empty) {
  if (!std::exchange(pending_, false)) {
    do {
      if (!next_line()) return false;
    } while (layout_.comments && without_blanks(text_, kBlank).starts_with('#'));
  }
  const auto cells = csv_cells(text_, layout_.separator);
  if (cells.size() == 1 && layout_.separator == ',') refuse_other_separator(text_, where());
  if (cells.size() != columns_) {
    throw InputError(
        where(), "", "found " + std::to_string(cells.size()) + (cells.size() == 1 ? " cell" : " cells"),
        "expected " + std::to_string(columns_) + (has_header_ ? ", as in the header" : ", as in the first row"));
  }
  values.clear();
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const bool missing = places_[i] == kMissing;
    values.push_back(missing ? std::numeric_limits<double>::quiet_NaN() : value_of(i, cells[places_[i]], may_be_empty));
  }
  return true;
}

std::string csv_text(std::string_view text) {
  const bool formula = !text.empty() && std::string_view("=+-@").find(text.front()) != std::string_view::npos;
  const std::string plain = (formula ? "'" : "") + printable(text);
  return plain.find_first_of(",\"") == std::string::npos ? plain : quoted_cell(plain);
}

std::string quoted_cell(std::string_view text) {
  return "\"" + replace_all(text, {{"\"", "\"\""}}) + "\"";
}

CsvWriter::CsvWriter(const std::string& path, const std::string& header, std::uintmax_t bytes)
    : path_(path), columns_(1 + static_cast<std::size_t>(std::ranges::count(header, ','))), whole_bytes_(bytes) {
  if (bytes > 0) cut_to_checkpoint(path, bytes);
  out_.rdbuf()->pubsetbuf(nullptr, 0);  // rows_ is the buffer
  out_.open(path, std::ios::binary | (bytes > 0 ? std::ios::app : std::ios::trunc));
  if (!out_) fail_to_write(path);
  if (bytes > 0) return;
  rows_ = header + '\n';
  flush();
}

CsvWriter::~CsvWriter() {
  if (out_.is_open() && out_) write_rows();  // finished frames are worth keeping after a failure
}

void CsvWriter::row(std::span<const double> values) {
  if (values.size() != columns_) {
    throw std::logic_error(fmt::format("{}: {} values for {} columns", path_, values.size(), columns_));
  }
  std::string row;  // appended whole: memory may be exhausted within it
  for (const double value : values) {
    if (!std::isnan(value)) row += shortest_text(value == 0 ? 0.0 : value);  // no "-0"
    row += ',';
  }
  row.back() = '\n';
  rows_ += row;
  if (rows_.size() > kBufferBytes) flush();
}

void CsvWriter::write_rows() {
  out_ << rows_;
  std::error_code ignored;
  if (out_) {
    whole_bytes_ += rows_.size();
  } else {
    std::filesystem::resize_file(path_, whole_bytes_, ignored);  // a full disk may have taken a part of a row
  }
  rows_.clear();
}

void CsvWriter::flush() {
  write_rows();
  if (!out_) fail_to_write(path_);
}

std::uintmax_t CsvWriter::sync() {
  flush();
  sync_to_disk(path_);
  return whole_bytes_;
}

void CsvWriter::close() {
  flush();
  close_file(out_, path_);
}

}  // namespace reamsim
