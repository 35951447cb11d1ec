// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "sim/anatomy/bone_probe.h"

namespace reamsim {

/// The edge of a face, found by walking over its surface.
struct RimWalk {
  std::vector<Vec3> rim_mm;  ///< where the surface turns away, in the order of the directions; in the walk's frame
  int directions = 0;        ///< that were walked; the others have no edge, as at the base of the coracoid
};

/// Walks over the surface from the origin of a frame on it, whose +z points out of the bone, in `directions` equal
/// steps of angle. A walk ends where the surface has fallen by 4 mm below its highest point or ends; the rim is its
/// corner, where it has turned to fall by 45 degrees. A walk has no rim where the surface rises steeply, or
/// extends beyond 35 mm.
RimWalk walk_to_rim(const BoneProbe& probe, const Rigid& bone_from_face, int directions);

}  // namespace reamsim
