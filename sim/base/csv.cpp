// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/csv.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <utility>

#include "sim/base/file.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

constexpr std::size_t kBufferBytes = 1 << 16;
/// Place of a column that is missing.
constexpr std::size_t kMissing = std::numeric_limits<std::size_t>::max();

double number(const SourceLocation& where, std::string_view name, std::string_view cell) {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
    throw InputError(where, std::string(name), "found '" + std::string(cell.substr(0, 40)) + "'",
                     "expected a finite number");
  }
  return value;
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

std::vector<std::string_view> csv_cells(std::string_view line) {
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

CsvReader::CsvReader(const std::string& path, std::span<const std::string_view> names, const std::string& expected,
                     std::span<const std::string_view> optional)
    : path_(path), names_(names.begin(), names.end()), in_(path, std::ios::binary) {
  std::string header;
  if (!in_ || !std::getline(in_, header)) throw InputError({path, 0, 0}, "", "cannot be read", expected);
  header = csv_header(std::move(header), {path, 1, 0});
  const auto found_names = csv_cells(header);
  names_.insert(names_.end(), optional.begin(), optional.end());
  for (const std::string_view name : names_) {
    const auto found = std::find(found_names.begin(), found_names.end(), name);
    const bool missing = found == found_names.end();
    if (missing && places_.size() < names.size())
      throw InputError({path, 1, 0}, std::string(name), "no such column", expected);
    places_.push_back(missing ? kMissing : static_cast<std::size_t>(found - found_names.begin()));
  }
}

bool CsvReader::next(std::vector<double>& values, std::string_view may_be_empty) {
  std::string line;
  do {
    if (!std::getline(in_, line)) {
      // std::getline() also swallows exceptions of the memory.
      if (in_.bad())
        throw RunError(path_ + ": cannot be read to its end; is the disk damaged, or the memory exhausted?");
      return false;
    }
    ++line_;
  } while (line.empty());
  const auto cells = csv_cells(line);
  if (cells.size() == 1) refuse_other_separator(line, where());
  values.clear();
  for (std::size_t i = 0; i < names_.size(); ++i) {
    if (places_[i] == kMissing) {
      values.push_back(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    if (places_[i] >= cells.size()) {
      throw InputError(where(), std::string(names_[i]),
                       "the line ends after " + std::to_string(cells.size()) + " cells",
                       "expected as many as in the header");
    }
    const std::string_view cell = cells[places_[i]];
    const bool empty = cell.empty() && names_[i] == may_be_empty;
    values.push_back(empty ? std::numeric_limits<double>::quiet_NaN() : number(where(), names_[i], cell));
  }
  return true;
}

std::string csv_text(std::string_view text) {
  const bool formula = !text.empty() && std::string_view("=+-@").find(text.front()) != std::string_view::npos;
  const std::string plain = (formula ? "'" : "") + printable(text);
  if (plain.find_first_of(",\"") == std::string::npos) return plain;
  std::string out = "\"";
  for (const char c : plain) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

CsvWriter::CsvWriter(const std::string& path, const std::string& header, std::ios::openmode mode)
    : path_(path), columns_(1 + static_cast<std::size_t>(std::ranges::count(header, ','))) {
  out_.rdbuf()->pubsetbuf(nullptr, 0);  // rows_ is the buffer
  out_.open(path, mode | std::ios::binary);
  check();
}

CsvWriter::CsvWriter(const std::string& path, const std::string& header)
    : CsvWriter(path, header, std::ios::out | std::ios::trunc) {
  rows_ = header + '\n';
  flush();
}

CsvWriter::CsvWriter(const std::string& path, const std::string& header, std::uintmax_t bytes)
    : CsvWriter(path, header, std::ios::app) {
  std::error_code error;
  const bool complete = std::filesystem::file_size(path, error) >= bytes && !error;
  if (!complete) {
    throw InputError({path, 0, 0}, "", "is shorter than when the checkpoint was written",
                     "start again with --overwrite");
  }
  std::filesystem::resize_file(path, bytes, error);
  if (error) fail_to_write(path);
  whole_bytes_ = bytes;
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
  check();
}

std::uintmax_t CsvWriter::sync() {
  flush();
  sync_to_disk(path_);
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path_, error);
  if (error) fail_to_write(path_);
  return bytes;
}

void CsvWriter::close() {
  flush();
  out_.close();
  check();
}

void CsvWriter::check() const {
  if (!out_) fail_to_write(path_);
}

}  // namespace reamsim
