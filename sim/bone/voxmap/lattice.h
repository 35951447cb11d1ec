#pragma once

#include <string>

#include "sim/bone/voxmap/voxel_grid.h"

namespace reamsim {

/// Room round a bone for the smoothing of the surface that pictures and `surface` need.
inline constexpr int kMarginVoxels = 4;

/// For each voxel of a mesh's bone while it is made, measured: grades, the distance field (a float and the number of
/// the nearest triangle) and their copies on the way.
inline constexpr double kMeshBytesPerVoxel = 13;

/// What of a lattice takes memory while its bone is made.
struct LatticeLoad {
  double bone_fraction = 1;    ///< the most that bricks with bone can take of the lattice, 0…1
  double bytes_per_voxel = 1;  ///< of these bricks: a byte of grade, and what its source needs beside
};

/// The machine's memory, bytes.
double machine_memory_bytes();

/// Throws InputError unless a lattice of `dims` voxels (as doubles, so that absurd sizes do not overflow) can be
/// numbered and its load fits into half of `memory_bytes`. The message begins with `what`, and says how many bytes are
/// wanted and which voxel size would fit. Call it before allocating.
void check_lattice(const std::string& what, const Eigen::Array3d& dims, double voxel_mm, const LatticeLoad& load = {},
                   double memory_bytes = machine_memory_bytes());

/// The lattice of `voxel_mm` whose planes lie at multiples of the voxel size from the origin of B, with `margin_voxels`
/// of room round `box_mm`, and dimensions that are multiples of 8 (whole bricks). Throws as check_lattice().
VoxelGrid lattice_around(const std::string& what, const Aabb& box_mm, double voxel_mm, int margin_voxels,
                         const LatticeLoad& load = {});

}  // namespace reamsim
