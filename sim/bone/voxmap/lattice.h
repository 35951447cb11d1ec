// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/bone/voxmap/voxel_grid.h"

namespace reamsim {

/// Air around a bone. Pictures and the grid `surface` smooth the surface and need it.
inline constexpr int kMarginVoxels = 4;

/// Measured memory per voxel while a mesh is voxelized: grades, the distance field (a float and the index of the
/// nearest triangle) and temporary copies.
inline constexpr double kMeshBytesPerVoxel = 13;

/// Which part of a lattice needs memory while the bone is built.
struct LatticeLoad {
  double bone_fraction = 1;    ///< upper bound of the fraction of the lattice in bricks with bone, 0…1
  double bytes_per_voxel = 1;  ///< in these bricks: one byte of grade, and what the source of the bone needs
};

double machine_memory_bytes();

/// Throws InputError unless a lattice of `dims` voxels can be indexed and its load fits into half of `memory_bytes`.
/// The message begins with `what`; it states the memory needed and the voxel size that would fit. Call it before
/// allocating. `dims` are doubles, so that absurd sizes do not overflow.
void check_lattice(const std::string& what, const Eigen::Array3d& dims, double voxel_mm, const LatticeLoad& load = {},
                   double memory_bytes = machine_memory_bytes());

/// The lattice of `voxel_mm` around `box_mm` with a margin of `margin_voxels`. Its planes lie at multiples of the voxel
/// size from the origin of B; its dimensions are multiples of 8 (whole bricks). Throws as check_lattice().
VoxelGrid lattice_around(const std::string& what, const Aabb& box_mm, double voxel_mm, int margin_voxels,
                         const LatticeLoad& load = {});

}  // namespace reamsim
