#pragma once

#include <optional>

#include "kernels/published.h"
#include "sim/bench/contender.h"

namespace reamsim::bench {

/// What the published kernels read of a substep: float arithmetic in shell cells and voxels. `voi` in T, mm; without it
/// the whole shell. Throws InputError unless the bone is a cube.
PublishedFrame published_frame(const Substep& substep, const std::optional<Aabb>& voi, const Tool& tool,
                               const VoxelGrid& grid);

/// For each level of the descent through a cube of 2^n voxels an edge, and each octant, what choosing it adds to a
/// voxel's index. Throws InputError where the edge is no power of two.
std::vector<cl_uint> descent_steps(int side);

/// Work-items per group of the published kernels.
inline constexpr std::size_t kPublishedGroup = 256;

}  // namespace reamsim::bench
