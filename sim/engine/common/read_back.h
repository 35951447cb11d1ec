// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "kernels/bricks.h"
#include "sim/bone/vdb/bone_vdb.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// Copies every fill of a dense array (an entry per voxel, in the order of VoxelGrid::index) that is not whole into
/// `fill`. Air is unchanged.
void copy_fill(const std::vector<std::uint16_t>& dense, const Voxmap& voxmap, FillBricks& fill);

/// Appends the voxels of a block, which were removed in `frame`.
void append_removed(const RemovedBlock& block, const VoxelGrid& grid, std::int32_t frame, RemovedFrames& removed);

}  // namespace reamsim
