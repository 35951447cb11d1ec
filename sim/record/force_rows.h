// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/record/results.h"

namespace reamsim {

/// The header of forces.csv.
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

/// The number of a frame or pass in forces.csv. Throw InputError for one that no run writes.
std::int64_t frame_number(double value, const SourceLocation& where);
int pass_number(double value, const SourceLocation& where);

/// The values of a row of forces.csv, in the order of its columns.
std::vector<double> force_row(const FrameResult& result);

/// The result in such a row; without those columns it is that of a run with a prescribed motion. `where`: the place of
/// the row, for the InputError of a frame, pass or number of contacts that no run writes.
FrameResult result_of(std::span<const double> row, const SourceLocation& where);

}  // namespace reamsim
