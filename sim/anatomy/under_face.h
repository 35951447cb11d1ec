// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/anatomy/reamed_face.h"

namespace reamsim {

/// Thickness of the dense bone under the reamed face, along the normal of the face, until the density falls below the
/// threshold. Less than about half a voxel counts as none.
struct RemainingDenseBone {
  double mean_mm = 0;
  double least_mm = 0;
  double p05_mm = 0;           ///< 5 % of the face have less
  double exposed_percent = 0;  ///< of the face without dense bone
};
/// nullopt where the face has no columns. `dense_g_cm3`: the least density of dense bone.
std::optional<RemainingDenseBone> remaining_dense_bone(const ReamedBone& bone, const ColumnMap& map,
                                                       const ReamedFace& face, double dense_g_cm3);

/// Reaming through the bone, as areas projected along z of the map.
struct Perforation {
  int holes = 0;
  double area_mm2 = 0;  ///< of the holes: reamed through, surrounded by bone
  /// Reamed through within kFaceEdgeVoxels of the edge of the bone, or connected to it. The bone has an edge to air,
  /// and where the surface beside it lies below all removed bone.
  double rim_area_mm2 = 0;
};
Perforation find_perforation(const ColumnMap& map, double voxel_mm);

}  // namespace reamsim
