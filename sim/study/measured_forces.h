// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

namespace reamsim {

/// A measured quantity: a column of forces.csv.
enum class ForceChannel {
  force_x,
  force_y,
  force_z,
  torque_x,
  torque_y,
  torque_z,
  axial_force,
  spin_torque,
};
inline constexpr int kForceChannels = 8;

/// Its column, "axial_force_n".
std::string column_of(ForceChannel channel);

/// A measured history of forces or torques.
struct MeasuredForces {
  std::vector<ForceChannel> channels;
  std::vector<double> time_s;
  std::vector<std::vector<double>> values;  ///< by channel and time; NaN where nothing was measured
  std::string file = {};                    ///< for messages
};

/// Reads a CSV file with `time_s` and any columns of ForceChannel; others are skipped, and cells may be empty. Axial
/// force and spin torque are left out where all three components are given, whose projections they are. Throws
/// InputError: no such file, no column, no row, times not ascending.
MeasuredForces read_measured_forces(const std::string& path);

}  // namespace reamsim
