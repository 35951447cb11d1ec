// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "sim/anatomy/joint_line.h"
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

/// A column under the footprint of an implant.
struct FootprintColumn {
  ColumnPlace place;
  double weight = 0;   ///< fraction of the column within the footprint
  double back_mm = 0;  ///< height of the implant's back above its apex
  bool hole = false;   ///< reamed through, surrounded by bone
};

/// An implant on the bone.
struct SeatedImplant {
  ColumnMap map;                                ///< along the axis, in the frame of the implant before it is seated
  double apex_mm = 0;                           ///< z of the seated apex in the map
  Rigid bone_from_implant = Rigid::Identity();  ///< of the seated implant
  std::vector<FootprintColumn> footprint;       ///< only where the implant has a back

  /// Distance from the back of the implant down to the bone, mm; negative where the bone is penetrated.
  [[nodiscard]] double gap_mm(const FootprintColumn& column) const {
    return apex_mm + column.back_mm - map.at(column.place).after_mm;
  }
  [[nodiscard]] double column_mm2() const { return map.pitch_mm * map.pitch_mm; }
};

/// Single voxels that project from the face do not support an implant.
inline constexpr double kYieldingFraction = 0.01;
/// Bone further below the back of an implant than this does not lie under it: the implant projects beyond the bone.
inline constexpr double kOverhangDepth_mm = 5;

/// Translates an implant from `bone_from_implant` along its axis until the highest kYieldingFraction of its footprint
/// has yielded; without ImplantSettings::seat it stays there. The footprint is its outline, or without one the reamed
/// face as seen along the axis. In an outline, unreamed bone supports the implant, and the core of a cannulated reamer
/// is excluded. nullopt where the footprint contains no bone.
std::optional<SeatedImplant> place_implant(const ReamedBone& bone, const Rigid& bone_from_implant,
                                           const ImplantShape& shape, const ImplantSettings& settings);

/// Contact between the back of an implant and the bone. Areas are projected along the axis.
struct Seating {
  double footprint_mm2 = 0;
  double seated_percent = 0;  ///< of the footprint, with a gap of at most ImplantSettings::gap_mm
  double mean_gap_mm = 0;     ///< over the part of the footprint with bone
  double max_gap_mm = 0;      ///< likewise
  double overhang_mm2 = 0;    ///< of the footprint beyond the edge of the bone
  double overhang_percent = 0;
  std::optional<double> dense_percent;  ///< dense fraction of the bone in the supporting layer; nullopt: no bone
};

/// `dense_g_cm3`: the least density of dense bone.
Seating measure_seating(const ReamedBone& bone, const SeatedImplant& implant, const ImplantSettings& settings,
                        double dense_g_cm3);

/// The bone around a peg of a seated implant. Its wall ends at the outer surface of the bone: air below the back of the
/// implant, but not the gap between back and bone, through which the peg enters.
struct PegWall {
  double length_mm = 0;      ///< of the axis below the back of the implant
  double in_bone_mm = 0;     ///< length of the axis over which the whole circumference lies in bone
  double perforated_mm = 0;  ///< length of the axis over which the circumference leaves the outer surface of the bone
  /// Least distance from the surface of the capsule to the outer surface; 0 where it perforates. nullopt where no part
  /// of the peg lies below the back.
  std::optional<double> least_wall_mm;
};

/// Remaining bone of the vault under the footprint of an implant. The vault reaches ImplantSettings::vault_depth_mm
/// below the unreamed surface, along the axis of the implant, and ends at the first air. Holes for pegs are not
/// subtracted.
struct Vault {
  double before_mm3 = 0;                ///< before reaming
  double left_mm3 = 0;                  ///< below the back of the implant
  double mean_depth_mm = 0;             ///< left_mm3 over the area of the footprint
  std::optional<double> axis_depth_mm;  ///< on the axis of the implant; nullopt beside the bone
};

/// What a surgeon plans by: pose, support and fixation of an implant in the reamed bone.
struct Planning {
  Rigid bone_from_implant = Rigid::Identity();  ///< of the seated implant
  Measured<FaceAngles> native;                  ///< of the face before reaming, in the scapular frame
  Measured<FaceAngles> planned;                 ///< of the axis of the implant, likewise
  /// Native − planned: positive where retroversion or superior tilt decreases. In the glenoid frame if there is no
  /// scapular frame.
  Measured<FaceAngles> corrected;
  /// Along the Friedman axis, from the native face to the articular surface: the plain back of the implant translated
  /// along its axis by ImplantSettings::thickness_mm. Positive is medial.
  Measured<double> medialization_mm;
  Seating seating;
  Vault vault;
  std::vector<PegWall> pegs;  ///< in the order of the settings
};

/// nullopt where the footprint of the implant contains no bone, or its frame is unknown.
std::optional<Planning> measure_planning(const ReamedBone& bone, const Rigid& bone_from_tool, const JointLine& line,
                                         const BoneAxes& axes, const MetricSettings& settings);

}  // namespace reamsim
