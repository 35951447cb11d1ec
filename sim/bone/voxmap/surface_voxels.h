#pragma once

#include <functional>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// What a bone's source knows of a voxel at its surface.
struct SurfaceVoxel {
  double fraction = 0;     ///< of its volume that is bone, 0…1
  std::uint8_t grade = 0;  ///< of that bone; not 0 where there is any
};

/// Looks at a voxel whose grade is `grade`, 0 where its centre lies outside. Called from several threads at once.
using SurfaceSampler = std::function<SurfaceVoxel(const Vec3i& voxel, std::uint8_t grade)>;

/// Gives each voxel at the bone's surface (one of the 27 round it is bone, and one is not) the fill that `sample`
/// finds, so that a voxel just outside becomes bone with the little that reaches into it (docs/physics.md, 1).
/// `voxmap` must be whole. The result does not depend on the threads.
void set_partial_fill(const SurfaceSampler& sample, FilledVoxmap& voxmap);

}  // namespace reamsim
