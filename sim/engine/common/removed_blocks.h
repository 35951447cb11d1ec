#pragma once

#include <span>

#include "kernels/bricks.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/voxmap/voxel_grid.h"

namespace reamsim {

/// Appends the voxels of a block's record, which went in `frame`.
void append_removed(const RemovedBlock& block, const VoxelGrid& grid, std::int32_t frame, RemovedFrames& removed);

}  // namespace reamsim
