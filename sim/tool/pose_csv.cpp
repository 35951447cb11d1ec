// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/pose_csv.h"

#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

enum Column { kTime, kX, kY, kZ, kQw, kQx, kQy, kQz, kSpin };
constexpr std::array<std::string_view, kSpin> kNames{"time_s", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"};
constexpr std::array<std::string_view, 1> kOptionalNames{"spin_rpm"};
constexpr const char* kPoseColumns = "the header must name time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz and optionally spin_rpm";
constexpr std::size_t kMaxRows = 10'000'000;
constexpr double kFarthest_mm = 1e6;
constexpr double kFastest_rpm = 1e6;
/// Warnings about single rows that are reported one by one; the others are counted.
constexpr std::size_t kMaxRowWarnings = 3;

void check_range(const SourceLocation& where, std::string_view name, double value, double most, const char* unit) {
  if (!(std::abs(value) <= most)) {
    throw InputError(where, std::string(name), "found " + rounded_text(value),
                     "at most " + rounded_text(most) + " " + unit + " is possible");
  }
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

}  // namespace

PoseCsv::PoseCsv(const CsvMotionSettings& settings, Diagnostics& report)
    : rows_(settings.path, kNames, kPoseColumns, kOptionalNames), spin_rpm_(settings.spin_rpm) {
  std::string ignored;
  for (const std::string& name : rows_.skipped()) ignored += (ignored.empty() ? "\"" : ", \"") + printable(name) + '"';
  if (!ignored.empty()) report.note(rows_.where().text() + ": ignored columns: " + ignored.substr(0, 200));
}

bool PoseCsv::next(KeyPose& pose, Diagnostics& row_report) {
  if (!rows_.next(row_)) return false;
  const SourceLocation where = rows_.where();
  for (const Column c : {kX, kY, kZ}) check_range(where, kNames[c], row_[c], kFarthest_mm, "mm");
  if (std::isnan(row_[kSpin])) row_[kSpin] = spin_rpm_;
  check_range(where, kOptionalNames[0], row_[kSpin], kFastest_rpm, "rpm");
  const Quat q(row_[kQw], row_[kQx], row_[kQy], row_[kQz]);
  pose = {row_[kTime],
          {{row_[kX], row_[kY], row_[kZ]}, normalized_or_warn(q, where.text(), row_report), 0, row_[kSpin]}};
  return true;
}

void scan_pose_csv(PoseCsv& csv, const std::string& path, Diagnostics& report,
                   const std::function<void(const KeyPose&, const PoseCsv::Place&)>& visit) {
  Diagnostics row_report;
  RowWarnings warnings;
  std::size_t rows = 0;
  double before_s = 0;
  KeyPose pose;
  for (PoseCsv::Place place = csv.place(); csv.next(pose, row_report); place = csv.place(), ++rows) {
    if (rows == kMaxRows) throw InputError(csv.where(), "", "more than ten million rows", "record at a lower rate");
    if (rows > 0 && !(pose.time_s > before_s)) {
      throw InputError(csv.where(), "", "time_s is " + rounded_text(pose.time_s) + " after " + rounded_text(before_s),
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
