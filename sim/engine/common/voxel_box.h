#pragma once

#include "kernels/shared.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// The volume of interest in voxmap coordinates (paper §4.3.2): the voxels of `bone` whose centres can lie in
/// `tool_box` (T, mm) in the substep's pose. It overestimates, and never misses.
VoxelBox voxel_voi(const SubstepArgs& args, const Aabb& tool_box, const VoxelBox& bone);

}  // namespace reamsim
