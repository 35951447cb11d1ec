// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <vector>

#include "sim/anatomy/implant_seating.h"
#include "sim/anatomy/joint_line.h"

namespace reamsim {

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
