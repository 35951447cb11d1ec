// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "sim/record/results.h"
#include "sim/record/run_totals.h"
#include "sim/tool/motion.h"

namespace reamsim {

/// Values of a row at another time than its own.
struct RowPoint {
  double time_s = 0;
  double depth_mm = 0;
  double removed_mm3 = 0;
  double cumulative_energy_mj = 0;
};

/// A row of forces.csv with sums and means over the rows up to it.
struct ForceRow : FrameResult {                  // removed_mm3: since the start
  double cumulative_energy_mj = 0;               ///< cutting energy since the start
  double cumulative_floor_mj = 0;                ///< speed-floor energy since the start
  double layer_axial_force_n = 0;                ///< mean over the last voxel of travel (LayerMean), or the frame
  double layer_spin_torque_nmm = 0;              ///< likewise
  Vec3 layer_force_n = Vec3::Zero();             ///< of a mean, the component along the tool's axis
  std::size_t layer_frames = 0;                  ///< number of frames in these means
  RowPoint layer_middle = {}, layer_begin = {};  ///< in the middle and before the first of these frames
};

/// DIR/forces.csv, in ascending frames. A long log is decimated.
struct ForceLog {
  std::vector<ForceRow> rows;
  double mean_travel_mm = 0;     ///< of the means in the rows
  std::int64_t bucket_rows = 1;  ///< rows of the file for each bucket of a decimated log; 1: all rows are there

  [[nodiscard]] bool is_decimated() const { return bucket_rows > 1; }
  /// The row of `frame`, or the first row when `frame` lies before it. Throws InputError when the run is shorter.
  [[nodiscard]] const ForceRow& at(std::int64_t frame, const std::string& path) const;
};

struct LogOptions {
  double mean_travel_mm = 0;                       ///< of the means (LayerMean); 0: single frames
  std::vector<std::int64_t> keep = {};             ///< frames whose rows are kept, ascending
  std::function<void(const ForceRow&)> each = {};  ///< called with every row
  std::size_t most_rows = 50'000;                  ///< a log with more is decimated (RowDecimator)
};

/// Collects the rows of a log in bounded memory. From a long log it keeps the first and the last row, given frames, and
/// of each of 2048 to 4096 buckets of successive rows the first and those with the extremes of each displayed quantity.
class RowDecimator {
 public:
  /// `keep`: frames, ascending.
  RowDecimator(std::vector<std::int64_t> keep, std::size_t most_rows)
      : keep_(std::move(keep)), most_rows_(most_rows), limit_(most_rows) {}

  void add(const ForceRow& row);
  std::vector<ForceRow> finish();
  /// Rows per bucket; 1 as long as all rows are kept.
  [[nodiscard]] std::int64_t bucket_rows() const { return bucket_rows_; }

 private:
  /// Removes rows that are neither first of their bucket, extreme nor kept. Buckets grow as the log does; what is an
  /// extreme of a bucket is one of its half, so it does not matter when this is called.
  void reduce();

  std::vector<std::int64_t> keep_;
  std::size_t most_rows_, limit_;  ///< more rows are reduced
  std::vector<ForceRow> rows_;
  std::vector<std::int64_t> numbers_;  ///< of these rows in the log
  std::int64_t count_ = 0, bucket_rows_ = 1;
  ForceRow last_;
};

/// Reads the columns in any order. Throws InputError: no such file, a column missing, not a number, not ascending, no
/// row.
ForceLog read_force_log(const std::string& path, const LogOptions& options = {});

/// Calls visit() with every row of forces.csv, without means. Throws as read_force_log().
void for_each_force_row(const std::string& path, const std::function<void(const ForceRow&)>& visit);

/// The headline of a log, by its means.
KeyResults key_results_of(const ForceLog& log);

/// What decides the poses of a run, beside the planned motion.
struct PoseFeedback {
  bool push = false;     ///< motion.push
  bool springs = false;  ///< motion.compliance; not with a push
};

/// The header of the forces.csv of a run.
std::string force_columns(PoseFeedback feedback);

/// The values of a row of forces.csv, in the order of its columns.
std::vector<double> force_row(const FrameResult& result);

/// Calls visit() with every row of such a forces.csv, each as it was written. Throws InputError: no such file, a column
/// missing, not a number, or a frame, pass or number of contacts that no run writes.
void for_each_result(const std::string& path, PoseFeedback feedback,
                     const std::function<void(const FrameResult&)>& visit);

}  // namespace reamsim
