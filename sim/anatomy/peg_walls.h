// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <vector>

#include "sim/anatomy/implant_seating.h"

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

/// One result per peg of the settings, in their order. Precision: see docs/metrics.md.
std::vector<PegWall> measure_pegs(const ReamedBone& bone, const SeatedImplant& implant, const ImplantShape& shape,
                                  const ImplantSettings& settings);

}  // namespace reamsim
