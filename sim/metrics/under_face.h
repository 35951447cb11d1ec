#pragma once

#include "sim/metrics/reamed_face.h"

namespace reamsim {

/// Dense bone that is left right under the reamed face, measured along the face's normal into the bone until the
/// density falls below the threshold. Less than about half a voxel of it counts as none.
struct RemainingDenseBone {
  double mean_mm = 0;
  double least_mm = 0;
  double p05_mm = 0;           ///< 5 % of the face have less under them
  double exposed_percent = 0;  ///< of the face that has none
};
/// Nothing where the face has no columns. `dense_g_cm3`: density from which on bone counts as dense.
std::optional<RemainingDenseBone> remaining_dense_bone(const ReamedBone& bone, const ColumnMap& map,
                                                       const ReamedFace& face, double dense_g_cm3);

/// Where reaming went right through the bone, in areas across the map's z.
struct Perforation {
  int holes = 0;
  double area_mm2 = 0;  ///< of the holes: reamed through, with bone all round
  /// Reamed away altogether within kFaceEdgeVoxels of the bone's edge or joined to it; there is an edge to air, and
  /// where the surface beside steps down below all that was lost.
  double rim_area_mm2 = 0;
};
Perforation find_perforation(const ColumnMap& map, double voxel_mm);

}  // namespace reamsim
