#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

// The voxmap as dense arrays, an entry per voxel in the order of VoxelGrid::index: what the serial engine and the dense
// device engines work on.

/// Whether some voxel has lost a part of its fill: neither whole nor gone.
bool partly_filled(const Voxmap& voxmap);

/// Voxels that are bone, reamed or not: the most that can ever go.
std::size_t count_unreamed(const Voxmap& voxmap);

/// Puts every fill that differs into the voxmap's bricks; air is left alone.
void copy_fill(const std::vector<std::uint16_t>& dense, Voxmap& voxmap);

}  // namespace reamsim
