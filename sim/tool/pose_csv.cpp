// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/pose_csv.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim {

/// The reader that PoseCsv hides.
namespace pose_rows {

enum Column { kTime, kX, kY, kZ, kQw, kQx, kQy, kQz, kSpin, kColumns };
constexpr std::array<std::string_view, kColumns> kNames{"time_s", "x_mm", "y_mm", "z_mm",    "qw",
                                                        "qx",     "qy",   "qz",   "spin_rpm"};
constexpr std::string_view kHeader = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz and optionally spin_rpm";
constexpr std::uintmax_t kMaxBytes = std::uintmax_t{4} << 30;
constexpr std::size_t kMaxLine = 4096;
constexpr std::size_t kMaxRows = 10'000'000;
constexpr double kFarthestMm = 1e6;
constexpr double kFastestRpm = 1e6;
/// Warnings about single rows that are reported one by one; the others are counted.
constexpr std::size_t kMaxRowWarnings = 3;

/// Text of a user's file for a message: shortened and printable.
std::string quoted(std::string_view text) {
  constexpr std::size_t kMost = 40;
  std::string out = "\"";
  for (const char c : text.substr(0, kMost)) out += c >= ' ' && c <= '~' ? c : '?';
  return out + (text.size() > kMost ? "…\"" : "\"");
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t start = 0;;) {
    const auto comma = line.find(',', start);
    std::string_view field = trimmed(line.substr(start, comma - start));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
    fields.push_back(field);
    if (comma == std::string_view::npos) return fields;
    start = comma + 1;
  }
}

/// Reads a file line by line with line numbers, and skips blank lines.
class LineReader {
 public:
  explicit LineReader(const std::string& path) : path_(path) {
    std::error_code failed;
    const auto status = std::filesystem::status(path, failed);
    if (failed || !std::filesystem::exists(status)) fail("no such file", "give a CSV of recorded poses");
    if (std::filesystem::is_directory(status)) fail("it is a folder", "give a CSV of recorded poses");
    const auto bytes = std::filesystem::file_size(path, failed);
    if (!failed && bytes > kMaxBytes) fail("larger than 4 GiB", "at most ten million rows are supported");
    stream_.open(path, std::ios::binary);
    if (!stream_) fail("cannot be opened", "check its permissions");
  }

  /// The next line that is not blank; false at the end of the file.
  bool next() {
    while (read_line()) {
      if (line_number_ == 1 && line_.starts_with("\xef\xbb\xbf")) line_.erase(0, 3);
      if (!trimmed(line_).empty()) return true;
    }
    return false;
  }

  [[nodiscard]] std::string_view line() const { return line_; }
  [[nodiscard]] PoseCsv::Place place() const { return {byte_, line_number_}; }
  void seek(const PoseCsv::Place& place) {
    stream_.clear();
    stream_.seekg(place.byte);
    byte_ = place.byte;
    line_number_ = place.line;
  }
  [[nodiscard]] SourceLocation here() const { return {path_, line_number_, 0}; }

  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError(here(), "", found, expected);
  }

 private:
  /// Lines are limited, so that a binary file is not read into memory.
  bool read_line() {
    std::array<char, kMaxLine> buffer{};
    stream_.getline(buffer.data(), buffer.size());
    if (stream_.bad()) fail("cannot be read", "check the disk");
    if (stream_.eof() && stream_.gcount() == 0) return false;
    ++line_number_;
    byte_ += stream_.gcount();
    if (stream_.fail() && !stream_.eof()) fail("a line of more than 4095 bytes", "is this a CSV file?");
    const auto got = static_cast<std::size_t>(stream_.gcount());
    line_.assign(buffer.data(), stream_.eof() ? got : got - 1);
    return true;
  }

  std::string path_;
  std::ifstream stream_;
  std::string line_;
  std::int64_t byte_ = 0;  ///< after the line
  int line_number_ = 0;
};

/// Position of each column in the file; −1 = absent.
struct Layout {
  std::array<int, kColumns> at{};
  std::size_t fields = 0;
};

Layout read_header(LineReader& lines, Diagnostics& report) {
  if (!lines.next()) lines.fail("the file is empty", "a header is needed: " + std::string(kHeader));
  refuse_other_separator(lines.line(), lines.here());
  Layout layout;
  layout.at.fill(-1);
  const auto names = split(lines.line());
  layout.fields = names.size();
  std::string ignored;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto known = std::find(kNames.begin(), kNames.end(), names[i]);
    if (known == kNames.end()) {
      ignored += (ignored.empty() ? "" : ", ") + quoted(names[i]);
      continue;
    }
    int& at = layout.at[static_cast<std::size_t>(known - kNames.begin())];
    if (at >= 0) lines.fail("column " + std::string(*known) + " stands twice", "give each column once");
    at = static_cast<int>(i);
  }
  for (std::size_t c = 0; c < kSpin; ++c)
    if (layout.at[c] < 0)
      lines.fail("no column " + std::string(kNames[c]) + " in the header " + quoted(lines.line()),
                 "the header must name " + std::string(kHeader));
  if (!ignored.empty()) report.note(lines.here().text() + ": ignored columns: " + ignored.substr(0, 200));
  return layout;
}

double number(const LineReader& lines, Column column, std::string_view field) {
  std::string_view digits = field;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const bool whole = error == std::errc{} && end == digits.data() + digits.size();
  if (!whole || !std::isfinite(value))
    lines.fail(std::string(kNames[column]) + " is " + quoted(field), "a finite number is needed");
  return value;
}

void check_range(const LineReader& lines, Column column, double value, double most, const std::string& unit) {
  if (std::abs(value) > most)
    lines.fail(std::string(kNames[column]) + " is " + rounded_text(value),
               "at most " + rounded_text(most) + " " + unit + " is possible");
}

KeyPose read_row(const LineReader& lines, const Layout& layout, double default_spin_rpm, Diagnostics& row_report) {
  const auto fields = split(lines.line());
  if (fields.size() == 1) refuse_other_separator(lines.line(), lines.here());
  if (fields.size() != layout.fields)
    lines.fail(std::to_string(fields.size()) + " fields", "the header has " + std::to_string(layout.fields));
  std::array<double, kColumns> value{};
  value[kSpin] = default_spin_rpm;
  for (std::size_t c = 0; c < kColumns; ++c)
    if (layout.at[c] >= 0)
      value[c] = number(lines, static_cast<Column>(c), fields[static_cast<std::size_t>(layout.at[c])]);
  for (const Column c : {kX, kY, kZ}) check_range(lines, c, value[c], kFarthestMm, "mm");
  check_range(lines, kSpin, value[kSpin], kFastestRpm, "rpm");
  const Quat q(value[kQw], value[kQx], value[kQy], value[kQz]);
  return {value[kTime],
          {{value[kX], value[kY], value[kZ]}, normalized_or_warn(q, lines.here().text(), row_report), 0, value[kSpin]}};
}

/// Reports the first warnings about rows, and counts the others.
class RowWarnings {
 public:
  /// Takes the warnings of a row.
  void take(Diagnostics& row, Diagnostics& report) {
    for (const std::string& warning : row.warnings) {
      if (count_++ < kMaxRowWarnings) report.warn(warning);
    }
    row.warnings.clear();
  }
  void finish(const std::string& path, Diagnostics& report) const {
    if (count_ <= kMaxRowWarnings) return;
    report.warn(path + ": the same of " + std::to_string(count_ - kMaxRowWarnings) + " more rows");
  }

 private:
  std::size_t count_ = 0;
};

}  // namespace pose_rows

struct PoseCsv::State {
  pose_rows::LineReader lines;
  pose_rows::Layout layout;
  double spin_rpm;
};

PoseCsv::PoseCsv(const CsvMotionSettings& settings, Diagnostics& report)
    : state_(new State{pose_rows::LineReader(settings.path), {}, settings.spin_rpm}) {
  state_->layout = pose_rows::read_header(state_->lines, report);
}
PoseCsv::PoseCsv(PoseCsv&&) noexcept = default;
PoseCsv::~PoseCsv() = default;

bool PoseCsv::next(KeyPose& pose, Diagnostics& row_report) {
  if (!state_->lines.next()) return false;
  pose = pose_rows::read_row(state_->lines, state_->layout, state_->spin_rpm, row_report);
  return true;
}

PoseCsv::Place PoseCsv::place() const {
  return state_->lines.place();
}

void PoseCsv::seek(const Place& place) {
  state_->lines.seek(place);
}

SourceLocation PoseCsv::here() const {
  return state_->lines.here();
}

void scan_pose_csv(PoseCsv& csv, const std::string& path, Diagnostics& report,
                   const std::function<void(const KeyPose&, const PoseCsv::Place&)>& visit) {
  Diagnostics row_report;
  pose_rows::RowWarnings warnings;
  std::size_t rows = 0;
  double before_s = 0;
  KeyPose pose;
  for (PoseCsv::Place place = csv.place(); csv.next(pose, row_report); place = csv.place(), ++rows) {
    if (rows == pose_rows::kMaxRows)
      throw InputError(csv.here(), "", "more than ten million rows", "record at a lower rate");
    if (rows > 0 && !(pose.time_s > before_s)) {
      throw InputError(csv.here(), "", "time_s is " + rounded_text(pose.time_s) + " after " + rounded_text(before_s),
                       "times must increase from row to row");
    }
    before_s = pose.time_s;
    warnings.take(row_report, report);
    visit(pose, place);
  }
  if (rows < 2) {
    throw InputError(SourceLocation{path, 0, 0}, "", std::to_string(rows) + " rows of poses",
                     "at least two are needed");
  }
  warnings.finish(path, report);
}

std::vector<KeyPose> read_pose_csv(const CsvMotionSettings& settings, Diagnostics& report) {
  PoseCsv csv(settings, report);
  std::vector<KeyPose> poses;
  scan_pose_csv(csv, settings.path, report, [&](const KeyPose& pose, const PoseCsv::Place&) { poses.push_back(pose); });
  return poses;
}

}  // namespace reamsim
