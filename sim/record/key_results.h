// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/base/text.h"

namespace reamsim {

/// The first figures of every summary: one force, one torque, one depth (docs/results.md, "Headline"). All outputs take
/// their names and texts from here.
struct KeyResults {
  bool means = false;  ///< force and torque are means over a voxel of travel; otherwise of single frames
  double peak_axial_force_n = 0;
  double peak_spin_torque_nmm = 0;  ///< magnitude
  double tool_depth_mm = 0;         ///< greatest travel along the tool's axis since first contact

  static constexpr const char* kDepthName = "tool depth";
  [[nodiscard]] std::string force_name() const { return means ? "peak mean axial force" : "peak axial force"; }
  [[nodiscard]] std::string torque_name() const { return means ? "peak mean spin torque" : "peak spin torque"; }

  /// The numbers as text, without their units (N, N·mm, mm).
  [[nodiscard]] std::string force_text() const { return fixed_text(peak_axial_force_n, 1); }
  [[nodiscard]] std::string torque_text() const { return fixed_text(peak_spin_torque_nmm, 0); }
  [[nodiscard]] std::string depth_text() const { return fixed_text(tool_depth_mm, 2); }

  [[nodiscard]] std::string force_definition() const {
    return std::string(
               "maximum component of the force along the tool axis, and largest magnitude of the torque about it, ") +
           (means ? "of the means over one voxel of travel" : "of a single frame");
  }
  static constexpr const char* kDepthDefinition = "maximum travel of the tool along its axis since first contact";
};

}  // namespace reamsim
