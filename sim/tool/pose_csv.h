// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/csv.h"
#include "sim/tool/key_track.h"

namespace reamsim {

/// Recorded poses, row by row, as the settings describe them: by default a header line and rows of
/// `time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz` and optionally `spin_rpm` (otherwise settings.spin_rpm), in any order of
/// columns; other columns are ignored with a note. A byte-order mark, CRLF, blank lines, comments (#) and blanks around
/// fields are tolerated. The poses are those of the tool in the frame of motion.frame: units, registration and
/// calibration of the settings are applied. With a max_gap_s rows without a pose are skipped. Every method throws
/// InputError with file and line: no such file, empty, missing or repeated column, wrong number of fields, not a finite
/// number, position beyond a kilometre, zero quaternion.
class PoseCsv {
 public:
  using Place = CsvReader::Place;

  PoseCsv(const CsvMotionSettings& settings, Diagnostics& report);

  /// Reads the next row; false at the end. `row_report` gets a warning about a quaternion that is no rotation.
  bool next(KeyPose& pose, Diagnostics& row_report);
  [[nodiscard]] Place place() const { return rows_.place(); }
  /// Goes on at a place that place() has returned. Only where the file is a regular one.
  void seek(const Place& place) { rows_.seek(place); }
  [[nodiscard]] SourceLocation where() const { return rows_.where(); }
  /// Rows without a pose that next() has skipped.
  [[nodiscard]] std::size_t skipped_rows() const { return skipped_rows_; }
  [[nodiscard]] double max_gap_s() const { return settings_.max_gap_s; }

 private:
  [[nodiscard]] bool has_pose() const;
  [[nodiscard]] KeyPose pose_of_row(Diagnostics& row_report) const;

  CsvMotionSettings settings_;
  CsvReader rows_;
  std::vector<double> row_;
  std::size_t skipped_rows_ = 0;
  std::optional<Rigid> bone_from_tracker_, marker_from_tool_;
};

/// Reads all rows, and calls visit(pose, place before its row). Besides the mistakes of rows, throws InputError where
/// times do not increase or have a gap of more than max_gap_s, and for fewer than two or more than ten million rows.
/// Times need not be equidistant.
void scan_pose_csv(PoseCsv& csv, const std::string& path, Diagnostics& report,
                   const std::function<void(const KeyPose&, const PoseCsv::Place&)>& visit);

/// All rows in memory.
std::vector<KeyPose> read_pose_csv(const CsvMotionSettings& settings, Diagnostics& report);

}  // namespace reamsim
