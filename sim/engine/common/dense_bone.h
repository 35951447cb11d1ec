#pragma once

#include <vector>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// Puts every fill of a dense array (an entry per voxel, in the order of VoxelGrid::index) that is not whole into
/// `fill`; air is left alone.
void copy_fill(const std::vector<std::uint16_t>& dense, const Voxmap& voxmap, FillBricks& fill);

}  // namespace reamsim
