#pragma once

#include <string>
#include <utility>
#include <vector>

namespace reamsim {

/// The figures that stand first wherever a run is summed up: one force, one torque, one depth (docs/formats.md,
/// "Headline"). Whoever shows one takes name and text from here, so that all show the same.
struct Headline {
  bool means = false;  ///< force and torque are means over a voxel of travel; otherwise of single frames
  double peak_axial_force_n = 0;
  double peak_spin_torque_nmm = 0;
  double tool_depth_mm = 0;  ///< greatest travel along the tool's axis since first contact

  static constexpr const char* kDepthName = "tool depth";
  [[nodiscard]] std::string force_name() const { return means ? "peak mean axial force" : "peak axial force"; }
  [[nodiscard]] std::string torque_name() const { return means ? "peak mean spin torque" : "peak spin torque"; }

  /// The numbers as text, without their units (N, N·mm, mm).
  [[nodiscard]] std::string force_text() const;
  [[nodiscard]] std::string torque_text() const;
  [[nodiscard]] std::string depth_text() const;

  /// How force and torque, and depth, are defined, for those who read a result without the documentation.
  [[nodiscard]] std::string force_definition() const;
  [[nodiscard]] static std::string depth_definition();
};

}  // namespace reamsim
