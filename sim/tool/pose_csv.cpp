// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/tool/motion.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "sim/base/csv.h"
#include "sim/base/text.h"

namespace reamsim {

namespace {

enum Column { kTime, kX, kY, kZ, kQw, kQx, kQy, kQz, kSpin };
constexpr std::array<std::string_view, kSpin> kNames{"time_s", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"};
constexpr const char* kPoseColumns =
    "the header must name time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz and optionally spin_rpm; other recordings: "
    "motion.csv.format, separator and columns";
constexpr const char* kDescribedColumns = "the columns that motion.csv names";
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

/// By Separator, LengthUnit and TimeUnit.
constexpr char kSeparators[] = {',', ';', '\t', ' '};
constexpr double kMmPerUnit[] = {1, 10, 1000, 1e-3, 25.4};
constexpr double kUnitsPerSecond[] = {1, 1e3, 1e6, 1e9};  // a division keeps decimal fractions

CsvColumn column_of(const std::string& text, bool may_be_missing = false) {
  const std::optional<std::uint64_t> number = whole_number(text);
  if (!number) return {text, 0, may_be_missing};
  return {"column " + text, static_cast<std::size_t>(*number), may_be_missing};
}

/// The layout of a file, with its columns in the order of Column.
CsvLayout layout_of(const CsvMotionSettings& settings) {
  CsvLayout out{.columns = {column_of(settings.time_column)},
                .separator = kSeparators[static_cast<std::size_t>(settings.separator)],
                .decimal_comma = settings.decimal == DecimalMark::comma,
                .comments = true,
                .missing_cells = settings.max_gap_s > 0,
                .skip_lines = settings.skip_lines};
  for (const std::string& column : settings.position_columns) out.columns.push_back(column_of(column));
  std::vector<std::string> quaternion = settings.quaternion_columns;
  if (settings.quaternion_order == QuaternionOrder::xyzw)
    std::rotate(quaternion.begin(), quaternion.end() - 1, quaternion.end());
  for (const std::string& column : quaternion) out.columns.push_back(column_of(column));
  out.columns.push_back(column_of(settings.spin_column, /*may_be_missing=*/true));
  return out;
}

/// False for a row without a pose. Throws InputError for a part of one, or no time.
bool has_pose(const std::vector<double>& row, const SourceLocation& where) {
  const auto missing = std::count_if(row.begin() + kX, row.begin() + kSpin, [](double v) { return std::isnan(v); });
  if (missing > 0 && missing < kSpin - kX)
    throw InputError(where, "", "a part of the pose is missing", "give all of it, or leave all of it empty");
  if (std::isnan(row[kTime])) throw InputError(where, "", "the time is missing", "each row needs one");
  return missing == 0;
}

/// Transforms of every row.
struct Registration {
  std::optional<Rigid> bone_from_tracker, marker_from_tool;
};

/// `report` gets a warning about a quaternion that is no rotation.
KeyPose pose_of_row(const CsvMotionSettings& settings, const Registration& registration, const std::vector<double>& row,
                    const SourceLocation& where, Diagnostics& report) {
  const Vec3 position_mm =
      kMmPerUnit[static_cast<std::size_t>(settings.position_unit)] * Vec3(row[kX], row[kY], row[kZ]);
  for (const Column c : {kX, kY, kZ}) check_range(where, kNames[c], position_mm[c - kX], kFarthest_mm, "mm");
  const double spin_rpm = std::isnan(row[kSpin]) ? settings.spin_rpm : row[kSpin];
  check_range(where, "spin_rpm", spin_rpm, kFastest_rpm, "rpm");
  const Quat q(row[kQw], row[kQx], row[kQy], row[kQz]);
  const double time_s = row[kTime] / kUnitsPerSecond[static_cast<std::size_t>(settings.time_unit)];
  KeyPose out{time_s, {position_mm, normalized_or_warn(q, where.text(), report), 0, spin_rpm}};
  ToolPose& pose = out.pose;
  if (const auto& marker_from_tool = registration.marker_from_tool) {
    pose.position_mm += pose.orientation * marker_from_tool->translation();
    pose.orientation = (pose.orientation * Quat(marker_from_tool->linear())).normalized();
  }
  if (registration.bone_from_tracker) move_pose(*registration.bone_from_tracker, pose);
  return out;
}

/// Refuses times that do not increase, and gaps of more than `most_s` > 0.
void check_interval(const SourceLocation& where, double before_s, double time_s, double most_s) {
  if (!(time_s > before_s)) {
    throw InputError(where, "", "time_s is " + shortest_text(time_s) + " after " + shortest_text(before_s),
                     "times must increase from row to row");
  }
  if (most_s > 0 && time_s - before_s > most_s) {
    throw InputError(
        where, "",
        "no pose for " + rounded_text(time_s - before_s) + " s, from " + shortest_text(before_s) + " s to this row",
        "at most " + rounded_text(most_s) + " s is allowed: repair the recording, or raise motion.csv.max_gap_s");
  }
}

}  // namespace

std::vector<KeyPose> read_pose_csv(const CsvMotionSettings& settings, Diagnostics& report) {
  const bool plain = settings.format == PoseFormat::csv && settings.separator == Separator::comma &&
                     settings.time_column == kNames[kTime] && settings.position_columns.front() == kNames[kX];
  CsvReader rows(settings.path, layout_of(settings), plain ? kPoseColumns : kDescribedColumns);
  std::string ignored;
  for (const std::string& name : rows.skipped()) ignored += (ignored.empty() ? "\"" : ", \"") + printable(name) + '"';
  if (!ignored.empty()) report.note(rows.where().text() + ": ignored columns: " + ignored.substr(0, 200));
  Registration registration;
  if (settings.bone_from_tracker) registration.bone_from_tracker = settings.bone_from_tracker->rigid();
  if (settings.marker_from_tool) registration.marker_from_tool = settings.marker_from_tool->rigid();
  std::vector<KeyPose> poses;
  std::size_t warnings = 0, skipped_rows = 0;
  for (std::vector<double> row; rows.next(row);) {
    const SourceLocation where = rows.where();
    if (!has_pose(row, where)) {
      ++skipped_rows;
      continue;
    }
    Diagnostics row_report;
    const KeyPose pose = pose_of_row(settings, registration, row, where, row_report);
    if (poses.size() == kMaxRows) throw InputError(where, "", "more than ten million rows", "record at a lower rate");
    if (!poses.empty()) check_interval(where, poses.back().time_s, pose.time_s, settings.max_gap_s);
    if (!row_report.warnings.empty() && warnings++ < kMaxRowWarnings) report.append(row_report);
    poses.push_back(pose);
  }
  const std::string& path = settings.path;
  if (poses.size() < 2) {
    throw InputError(SourceLocation{path, 0, 0}, "", std::to_string(poses.size()) + " rows of poses",
                     "at least two are needed");
  }
  if (warnings > kMaxRowWarnings)
    report.warn(path + ": the same of " + std::to_string(warnings - kMaxRowWarnings) + " more rows");
  if (skipped_rows > 0) report.note(path + ": " + std::to_string(skipped_rows) + " rows without a pose were skipped");
  return poses;
}

}  // namespace reamsim
