#include "sim/motion/pose_csv.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

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
    if (stream_.fail() && !stream_.eof()) fail("a line of more than 4095 bytes", "is this a CSV file?");
    const auto got = static_cast<std::size_t>(stream_.gcount());
    line_.assign(buffer.data(), stream_.eof() ? got : got - 1);
    return true;
  }

  std::string path_;
  std::ifstream stream_;
  std::string line_;
  int line_number_ = 0;
};

/// Position of each column in the file; −1 = absent.
struct Layout {
  std::array<int, kColumns> at{};
  std::size_t fields = 0;
};

Layout read_header(LineReader& lines, Report& report) {
  if (!lines.next()) lines.fail("the file is empty", "a header is needed: " + std::string(kHeader));
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

KeyPose read_row(const LineReader& lines, const Layout& layout, double default_spin_rpm, Report& row_report) {
  const auto fields = split(lines.line());
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

/// Reports the first warnings about rows, and the number of the others.
void report_rows(const Report& rows, const std::string& path, Report& report) {
  const std::size_t shown = std::min(kMaxRowWarnings, rows.warnings.size());
  for (std::size_t i = 0; i < shown; ++i) report.warn(rows.warnings[i]);
  if (rows.warnings.size() > shown)
    report.warn(path + ": the same of " + std::to_string(rows.warnings.size() - shown) + " more rows");
}

}  // namespace

std::vector<KeyPose> read_pose_csv(const CsvMotionSettings& settings, Report& report) {
  LineReader lines(settings.path);
  const Layout layout = read_header(lines, report);
  std::vector<KeyPose> poses;
  Report row_report;
  while (lines.next()) {
    if (poses.size() == kMaxRows) lines.fail("more than ten million rows", "record at a lower rate");
    KeyPose pose = read_row(lines, layout, settings.spin_rpm, row_report);
    if (!poses.empty() && !(pose.time_s > poses.back().time_s))
      lines.fail("time_s is " + rounded_text(pose.time_s) + " after " + rounded_text(poses.back().time_s),
                 "times must increase from row to row");
    poses.push_back(pose);
  }
  if (poses.size() < 2)
    throw InputError(SourceLocation{settings.path, 0, 0}, "", std::to_string(poses.size()) + " rows of poses",
                     "at least two are needed");
  report_rows(row_report, settings.path, report);
  return poses;
}

}  // namespace reamsim
