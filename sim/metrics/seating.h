#pragma once

#include "sim/metrics/reamed_face.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

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
