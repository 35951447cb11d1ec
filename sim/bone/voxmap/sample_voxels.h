// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// Sets the voxels of one brick, which is all air before. Returns whether it set any. Called from several threads at
/// once, each with its own brick.
using BrickSampler = std::function<bool(const Vec3i& brick_coord, GradeBricks::Brick& brick)>;

/// The grades of a lattice of `dims` voxels, sampled brick by brick in parallel. The result does not depend on the
/// threads.
GradeBricks sample_bricks(const Vec3i& dims, const BrickSampler& sample);

/// A voxel at the surface of a bone, as the source of the bone describes it.
struct SurfaceVoxel {
  double fraction = 0;     ///< of its volume that is bone, 0…1
  std::uint8_t grade = 0;  ///< of that bone; not 0 where there is any
};

/// Describes a voxel whose grade is `grade`, 0 where its centre lies outside. Called from several threads at once.
using SurfaceSampler = std::function<SurfaceVoxel(const Vec3i& voxel, std::uint8_t grade)>;

/// Sets the fill of the voxels at the bone's surface: those whose 3×3×3 neighbourhood contains bone and air. A voxel
/// whose centre lies just outside becomes bone with a small fill (docs/density.md, 1).
/// All voxels of `voxmap` must be whole. The result does not depend on the threads.
void set_partial_fill(const SurfaceSampler& sample, FilledVoxmap& voxmap);

}  // namespace reamsim
