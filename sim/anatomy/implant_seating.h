// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <vector>

#include "sim/anatomy/column_map.h"
#include "sim/anatomy/implant_shape.h"

namespace reamsim {

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

}  // namespace reamsim
