#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/motion/motion.h"
#include "sim/record/headline.h"

namespace reamsim {

/// The columns of forces.csv that pictures and plots need, for one frame.
struct ForceRow {
  std::int64_t frame = 0;
  double time_s = 0;
  ToolPose pose;
  double depth_mm = 0;
  double axial_force_n = 0;
  double spin_torque_nmm = 0;
  double removed_mm3 = 0;             ///< since the start
  double cumulative_energy_mj = 0;    ///< cutting energy since the start
  Vec3 force_n = Vec3::Zero();        ///< of the bone on the tool, in B
  double layer_axial_force_n = 0;     ///< mean over the last voxel of travel, see add_layer_means()
  double layer_spin_torque_nmm = 0;   ///< likewise
  Vec3 layer_force_n = Vec3::Zero();  ///< of a mean, the component along the tool's axis
  std::size_t layer_frames = 0;       ///< number of frames in these means
};

/// DIR/forces.csv, in ascending frames.
struct ForceLog {
  std::vector<ForceRow> rows;

  /// The row of `frame`, or the first row when `frame` lies before it. Throws InputError when the run is shorter.
  [[nodiscard]] const ForceRow& at(std::int64_t frame, const std::string& path) const;
};

/// Reads the columns in any order. Throws InputError with file, line and column: no such file, a column missing, not a
/// number, frames not ascending, no row.
ForceLog read_force_log(const std::string& path);

/// Computes the means over the last `travel_mm` of the tool's travel (sim/record/layer_mean.h); 0: of single frames.
void add_layer_means(ForceLog& log, double travel_mm);

/// The headline of a log with its means. `means`: they are over a voxel of travel.
Headline headline_of(const ForceLog& log, bool means);

}  // namespace reamsim
