#pragma once

#include <openvdb/openvdb.h>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// The bone's surface as a narrow-band level set, mm, negative inside: where the occupancy (fill where there is bone),
/// smoothed over 3×3×3 voxels with weights 1-2-1 along each axis, is one half. Without bone left the grid is empty.
openvdb::FloatGrid::Ptr surface_level_set(const BoneView& bone);

/// Isotropic, in mm, index (0,0,0) at the centre of voxel (0,0,0).
openvdb::math::Transform::Ptr index_transform(const VoxelGrid& grid);

}  // namespace reamsim
