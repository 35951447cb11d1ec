// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/error.h"
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

/// The columns of forces.csv that pictures and plots need, for one frame.
struct ForceRow {
  std::int64_t frame = 0;
  int pass = 1;  ///< of the tool
  double time_s = 0;
  ToolPose pose;
  double depth_mm = 0;
  double axial_force_n = 0;
  double spin_torque_nmm = 0;
  double removed_mm3 = 0;              ///< since the start
  double cumulative_energy_mj = 0;     ///< cutting energy since the start
  double cumulative_floor_mj = 0;      ///< speed-floor energy since the start
  double balance = 0;                  ///< energy balance
  Vec3 force_n = Vec3::Zero();         ///< of the bone on the tool, in B
  double layer_axial_force_n = 0;      ///< mean over the last voxel of travel, see add_layer_means()
  double layer_spin_torque_nmm = 0;    ///< likewise
  Vec3 layer_force_n = Vec3::Zero();   ///< of a mean, the component along the tool's axis
  std::size_t layer_frames = 0;        ///< number of frames in these means
  RowPoint layer_middle, layer_begin;  ///< in the middle and before the first of these frames
  std::optional<PushResult> push;      ///< of a tool that a hand pushes
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
  double mean_travel_mm = 0;                       ///< see add_layer_means()
  std::vector<std::int64_t> keep = {};             ///< frames whose rows are kept, ascending
  std::function<void(const ForceRow&)> each = {};  ///< called with every row
  std::size_t most_rows = 50'000;                  ///< a log with more is decimated (RowDecimator)
};

/// Collects the rows of a log in bounded memory. From a long log it keeps the first and the last row, given frames, and
/// of each of 2048 to 4096 buckets of successive rows the first and those with the extremes of each displayed quantity.
class RowDecimator {
 public:
  /// `keep`: frames, ascending.
  RowDecimator(std::vector<std::int64_t> keep, std::size_t most_rows) : keep_(std::move(keep)), most_rows_(most_rows) {}

  void add(const ForceRow& row);
  std::vector<ForceRow> finish();
  /// Rows per bucket; 1 as long as all rows are kept.
  [[nodiscard]] std::int64_t bucket_rows() const { return bucket_rows_; }

 private:
  using Bucket = std::vector<ForceRow>;

  void start_buckets();
  void add_to_bucket(const ForceRow& row);
  void merge_pairs();
  /// Removes rows that are neither first, extreme nor kept.
  void reduce(Bucket& bucket) const;

  std::vector<std::int64_t> keep_;
  std::size_t most_rows_;
  Bucket rows_;  ///< all rows, or none once there are buckets
  std::vector<Bucket> buckets_;
  std::int64_t bucket_rows_ = 1;
  std::int64_t in_last_ = 0;  ///< rows that the last bucket has received
  ForceRow last_;
};

/// Reads the columns in any order. Throws InputError: no such file, a column missing, not a number, not ascending, no
/// row.
ForceLog read_force_log(const std::string& path, const LogOptions& options = {});

/// Calls visit() with every row of forces.csv, without means. Throws as read_force_log().
void for_each_force_row(const std::string& path, const std::function<void(const ForceRow&)>& visit);

/// Sets the means over the last `travel_mm` of travel (LayerMean; 0: single frames), but in a decimated log only for 0.
void add_layer_means(ForceLog& log, double travel_mm);

/// The headline of a log with its means. `means`: they are over a voxel of travel.
KeyResults key_results_of(const ForceLog& log, bool means);

inline constexpr const char* kForceColumns =
    "frame,time_s,tool_x_mm,tool_y_mm,tool_z_mm,tool_qw,tool_qx,tool_qy,tool_qz,spin_rpm,spin_angle_rad,depth_mm,"
    "force_x_n,force_y_n,force_z_n,torque_x_nmm,torque_y_nmm,torque_z_nmm,axial_force_n,spin_torque_nmm,contacts,"
    "removed_mm3,energy_mj,floor_energy_mj,balance,pass";

/// The columns that follow in a run whose tool a hand pushes.
inline constexpr const char* kPushColumns = ",feed_mm_s,velocity_mm_s,thrust_n,hand_force_n,hand_power_w,drill_power_w";

/// Those of a tool on springs.
inline constexpr const char* kDeflectionColumns = ",deflection_x_mm,deflection_y_mm,deflection_z_mm";

/// What decides the poses of a run, beside the planned motion.
struct PoseFeedback {
  bool push = false;     ///< motion.push
  bool springs = false;  ///< motion.compliance; not with a push
};

/// The header of the forces.csv of a run.
std::string force_columns(PoseFeedback feedback);

/// The values of a row of forces.csv, in the order of its columns.
std::vector<double> force_row(const FrameResult& result);

/// The result in such a row. Throws InputError at `where` for a frame, pass or number of contacts that no run writes.
FrameResult result_of(std::span<const double> row, const SourceLocation& where);

}  // namespace reamsim
