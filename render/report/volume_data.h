#pragma once

#include <cstdint>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// Densities of the unreamed bone on a coarse lattice, for the colours of a cut through it.
struct DensityVolume {
  Vec3i dims = Vec3i::Zero();     ///< cells; x fastest
  Vec3 origin_mm = Vec3::Zero();  ///< lower corner of cell (0, 0, 0), B
  double cell_mm = 0;
  std::vector<std::uint8_t> grades;  ///< see sim/bone/density.h
};

/// Means over the bone in cubes of n³ voxels, n the least for which there are at most `most_cells` cells. The bone's
/// outer cells are carried on into the air round it, so that interpolation at its edge does not mix it with air.
/// Throws InputError when there is no bone.
DensityVolume density_volume(const Voxmap& voxmap, std::int64_t most_cells);

}  // namespace reamsim
