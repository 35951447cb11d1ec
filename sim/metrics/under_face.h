#pragma once

#include "sim/metrics/reamed_face.h"
#include "sim/scenario/scenario.h"

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

/// Contact between the back of an implant and the bone. The implant is translated along −z of the map, its apex on the
/// axis x = y = 0, until the highest kYieldingFraction of the footprint has yielded.
struct Seating {
  double footprint_mm2 = 0;   ///< projected along the axis
  double seated_percent = 0;  ///< of the footprint, with a gap of at most ImplantSettings::gap_mm
  double mean_gap_mm = 0;     ///< over columns with bone
  double max_gap_mm = 0;      ///< likewise
};

/// Single voxels that project from the face do not support an implant.
inline constexpr double kYieldingFraction = 0.01;

/// The footprint is the reamed face, or with a diameter the circle around the axis. In the circle, unreamed bone
/// supports the implant, and a column without bone is not seated. The core of a cannulated reamer is excluded.
/// nullopt where the footprint contains no bone. Needs a map along the reamer's axis.
std::optional<Seating> seat_implant(const ColumnMap& map, const ReamedFace& face, const ImplantSettings& implant,
                                    double voxel_mm);

}  // namespace reamsim
