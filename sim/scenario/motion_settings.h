// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/scenario/choices.h"

namespace reamsim {

// Tool and motion of a scenario; see scenario.h.

// ---- tool ------------------------------------------------------------------------------------------------------

/// A part of shaft or holder, which does not cut and must not touch: a cylinder or cone about z of T.
struct HolderPartSettings {
  std::string name;  ///< for messages; "": its number
  double from_z_mm = 0;
  double to_z_mm = 0;
  double diameter_mm = 0;      ///< at from_z_mm
  double end_diameter_mm = 0;  ///< at to_z_mm; 0: the same
};

struct ToolSettings {
  std::string mesh;  ///< STL, OBJ or PLY in the tool frame T
  double scale = 1;
  int shell_resolution = 0;            ///< M of the M³ grid; 0 = spacing of 0.47 voxel, which leaks nothing
  ToolSpin spin = ToolSpin::envelope;  ///< envelope of revolution | resolved cutting edges
  std::vector<HolderPartSettings> holder;
};

/// Soft tissue from which a holder is kept clear, as a mesh in B.
struct ClearanceEnvelopeSettings {
  std::string path;
  double scale = 1;
};

struct ClearanceSettings {
  double least_mm = 0;  ///< of the holder; less is warned of
  std::optional<ClearanceEnvelopeSettings> envelope{};
};

// ---- motion ----------------------------------------------------------------------------------------------------

struct PlungeSettings {
  Vec3 entry_mm = Vec3::Zero();
  Vec3 axis{0, 0, -1};                    ///< direction of the feed, opposite to +z of T
  PlungeStart from = PlungeStart::entry;  ///< where depth and approach begin
  double approach_mm = 2;
  double feed_mm_s = 1;
  double depth_mm = 4;
  double dwell_s = 0.2;
  double retract_mm = 6;
  double retract_mm_s = 10;
  double spin_rpm = 250;
};

/// A hand that pushes the tool along a line. The feed follows from the balance of forces.
struct PushSettings {
  Vec3 entry_mm = Vec3::Zero();
  Vec3 axis{0, 0, -1};                    ///< direction of the push, opposite to +z of T
  PlungeStart from = PlungeStart::entry;  ///< where depth and approach begin
  double approach_mm = 2;
  double thrust_n = 50;
  std::string profile{};  ///< CSV of the thrust over time, instead of thrust_n; "" = none
  double max_feed_mm_s = 5;
  double spin_rpm = 250;
  PushEnd until = PushEnd::depth;
  double depth_mm = 4;        ///< until: depth
  double time_s = 60;         ///< ends the push in any case
  double mass_kg = 0;         ///< of hand and handpiece; 0: the forces balance in every frame
  double damping_n_s_mm = 0;  ///< of the hand: force per feed
};

/// Springs between the planned pose and the tool, along the axes of the planned T. The tool does not tilt.
struct ComplianceSettings {
  static constexpr double kRigid_n_mm = 1e6;  ///< from here on the tool does not deflect in that direction

  Vec3 stiffness_n_mm{50, 50, kRigid_n_mm};
  double damping_n_s_mm = 0;  ///< of the viscous damper beside each spring
};

struct KeyframeSettings {
  double time_s = 0;
  Vec3 position_mm = Vec3::Zero();
  std::optional<Vec3> axis;        ///< +z of T; or
  std::optional<Quat> quaternion;  ///< w, x, y, z of bone_from_tool
  double spin_rpm = 0;
};

/// A transform without scale: a point p becomes R·p + translation_mm.
struct TransformSettings {
  Vec3 translation_mm = Vec3::Zero();
  std::optional<Quat> quaternion{};  ///< R; or
  std::vector<Vec3> rotation{};      ///< the rows of R; empty with the quaternion; without both R is the identity

  [[nodiscard]] Rigid rigid() const;
  [[nodiscard]] Mat3 rotation_matrix() const;  ///< of three rows
};

/// Recorded poses. A column is the name in the header, or its number from 1.
struct CsvMotionSettings {
  std::string path;
  double spin_rpm = 250;  ///< where the file has no such column
  PoseFormat format = PoseFormat::csv;
  Separator separator = Separator::comma;
  DecimalMark decimal = DecimalMark::point;
  int skip_lines = 0;  ///< before the header
  std::string time_column = "time_s";
  TimeUnit time_unit = TimeUnit::s;
  std::vector<std::string> position_columns{"x_mm", "y_mm", "z_mm"};
  LengthUnit position_unit = LengthUnit::mm;
  std::vector<std::string> quaternion_columns{"qw", "qx", "qy", "qz"};
  QuaternionOrder quaternion_order = QuaternionOrder::wxyz;
  std::string spin_column = "spin_rpm";
  double max_gap_s = 0;  ///< between two poses; 0: any
  std::optional<TransformSettings> bone_from_tracker{};
  std::optional<TransformSettings> marker_from_tool{};
};

/// The layout of a TUM trajectory: `t tx ty tz qx qy qz qw`, s and m.
void apply_format_defaults(CsvMotionSettings& csv);

/// A plunge of a procedure with several reamers.
struct PassSettings {
  std::optional<ToolSettings> tool;  ///< without it that of the scenario
  PlungeSettings plunge;
};

struct MotionSettings {
  PoseFrame frame = PoseFrame::bone;
  double frame_rate_hz = 1000;
  std::optional<PlungeSettings> plunge;
  std::optional<PushSettings> push;
  std::vector<PassSettings> passes;
  std::vector<KeyframeSettings> keyframes;
  std::optional<CsvMotionSettings> csv;
  std::optional<ComplianceSettings> compliance;

  /// Whether the poses are known before the run.
  [[nodiscard]] bool is_prescribed() const { return !push && !compliance; }
};

}  // namespace reamsim
