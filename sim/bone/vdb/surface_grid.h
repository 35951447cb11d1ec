// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <openvdb/openvdb.h>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// The surface of the bone as a narrow-band level set, mm, negative inside. It is the isosurface 0.5 of the occupancy
/// (fill of bone), smoothed over 3×3×3 voxels with weights 1-2-1 along each axis. Without remaining bone the grid is
/// empty.
openvdb::FloatGrid::Ptr surface_level_set(const BoneView& bone);

/// Isotropic, in mm, index (0,0,0) at the centre of voxel (0,0,0).
openvdb::math::Transform::Ptr index_transform(const VoxelGrid& grid);

}  // namespace reamsim
