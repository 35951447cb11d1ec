// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <openvdb/openvdb.h>

namespace reamsim {

/// Half width of the band of a level set, voxels.
inline constexpr float kHalfBandVoxels = 3;

/// The level set of the surface where an occupancy is one half: signed distance in units of the transform, negative
/// inside, active within kHalfBandVoxels of the surface. `occupancy`: leaves where it is not constant, tiles of 1
/// inside, background 0. A voxel's distance is that of the closest point of the trilinear interpolation. On spheres of
/// 5 to 40 mm in voxels of 0.5 mm, the largest error within a voxel of the surface is 0.14 voxels; of
/// openvdb::tools::fogToSdf it is 0.41, in five to eight times the time.
openvdb::FloatGrid::Ptr narrow_band(const openvdb::FloatGrid& occupancy);

}  // namespace reamsim
