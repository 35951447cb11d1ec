// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <optional>

#include "sim/anatomy/joint_line.h"
#include "sim/base/geometry.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The back of an implant over its footprint, in the frame I of the implant: origin at the apex of the plain back, +z
/// out of the bone, +y superior; mm.
class ImplantShape {
 public:
  explicit ImplantShape(const ImplantSettings& settings);

  /// Height of the back, augment included; nullopt beside a spherical back.
  [[nodiscard]] std::optional<double> back_mm(const Vec2& place) const;
  /// Height of the back with a place outside the footprint moved towards the axis, to the edge of the footprint.
  [[nodiscard]] double level_mm(const Vec2& place) const;

  /// Whether the footprint has an outline of its own; otherwise it is the reamed face.
  [[nodiscard]] bool has_outline() const { return half_width_mm_ > 0; }
  /// Whether a place lies within the outline; true without one.
  [[nodiscard]] bool covers(const Vec2& place) const;
  /// The fraction of a square cell within the outline, from 8 × 8 points.
  [[nodiscard]] double covered_fraction(const Vec2& center, double cell_mm) const;
  /// Half the longer side of the outline's bounding box.
  [[nodiscard]] double reach_mm() const { return std::max(half_width_mm_, half_height_mm_); }
  /// Depth of the lowest point of the augment below the apex of the plain back.
  [[nodiscard]] double augment_depth_mm() const;

 private:
  [[nodiscard]] std::optional<double> plain_mm(const Vec2& place) const;
  [[nodiscard]] std::optional<double> wedge_mm(const Vec2& place) const;

  double radius_mm_;  ///< 0: flat
  double half_width_mm_;
  double half_height_mm_;
  FootprintShape shape_;
  std::optional<AugmentSettings> augment_;
  Vec2 toward_ = Vec2::UnitX();          ///< of the augment
  Vec3 wedge_center_mm_ = Vec3::Zero();  ///< of the rotated sphere
};

/// The pose of an implant before it is seated: its apex at `center_mm`. +y is the superior direction (of the settings,
/// else of the glenoid or scapular frame, else +y of the settings' frame) projected across the axis. nullopt for a
/// glenoid frame that is unknown.
std::optional<Rigid> implant_pose(const ImplantSettings& settings, const Rigid& bone_from_tool, const BoneAxes& axes);

}  // namespace reamsim
