#pragma once

#include <string>

#include "sim/bone/voxel_grid.h"

namespace reamsim {

/// The most voxels of a lattice: 2048³.
inline constexpr double kMaxLatticeVoxels = 2048.0 * 2048.0 * 2048.0;

/// Throws InputError unless a lattice of `dims` voxels (as doubles, so that absurd sizes do not overflow) holds at most
/// kMaxLatticeVoxels and its grades fit into this machine's memory. The message begins with `what` and says which voxel
/// size would fit. Call it before allocating.
void check_lattice(const std::string& what, const Eigen::Array3d& dims, double voxel_mm);

/// The lattice of `voxel_mm` whose planes lie at multiples of the voxel size from the origin of B, with `margin_voxels`
/// of room round `box_mm`, and dimensions that are multiples of 8 (whole bricks). Throws as check_lattice().
VoxelGrid lattice_around(const std::string& what, const Aabb& box_mm, double voxel_mm, int margin_voxels);

}  // namespace reamsim
