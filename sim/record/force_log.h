// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/record/key_results.h"
#include "sim/record/results.h"
#include "sim/tool/tool_pose.h"

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

/// How a log is read.
struct LogOptions {
  double mean_travel_mm = 0;                       ///< see add_layer_means()
  std::vector<std::int64_t> keep = {};             ///< frames whose rows are kept, ascending
  std::function<void(const ForceRow&)> each = {};  ///< called with every row
  std::size_t most_rows = 50'000;                  ///< a log with more is decimated (row_decimator.h)
};

/// Reads the columns in any order, in one pass. Throws InputError with file, line and column: no such file, a column
/// missing, not a number, frames not ascending, no row.
ForceLog read_force_log(const std::string& path, const LogOptions& options = {});

/// Calls visit() with every row of forces.csv, without means. Throws as read_force_log().
void for_each_force_row(const std::string& path, const std::function<void(const ForceRow&)>& visit);

/// Computes the means over the last `travel_mm` of the tool's travel (sim/record/layer_mean.h); 0: of single frames. A
/// decimated log keeps the means that it was read with, unless `travel_mm` is 0.
void add_layer_means(ForceLog& log, double travel_mm);

/// The headline of a log with its means. `means`: they are over a voxel of travel.
KeyResults key_results_of(const ForceLog& log, bool means);

}  // namespace reamsim
