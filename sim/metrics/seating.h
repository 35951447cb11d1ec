#pragma once

#include "sim/metrics/reamed_face.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// How an implant's back lies on the bone: put down along −z of the map, its apex on the axis x = y = 0, until the
/// highest kYieldingFraction of the footprint have given way.
struct Seating {
  double footprint_mm2 = 0;   ///< across the axis
  double seated_percent = 0;  ///< of the footprint, with a gap of at most ImplantSettings::gap_mm
  double mean_gap_mm = 0;     ///< where there is bone below
  double max_gap_mm = 0;      ///< likewise
};

/// Single grains stand out of a face of voxels; they do not carry an implant.
inline constexpr double kYieldingFraction = 0.01;

/// The footprint is the reamed face, or with a diameter the circle round the axis: what is not reamed there holds the
/// implant off, and what has no bone is not seated. The core that a cannulated reamer leaves standing does not count.
/// Nothing where the footprint holds no bone. Needs a map along the reamer's axis.
std::optional<Seating> seat_implant(const ColumnMap& map, const ReamedFace& face, const ImplantSettings& implant,
                                    double voxel_mm);

}  // namespace reamsim
