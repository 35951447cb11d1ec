#pragma once

#include <functional>

#include "sim/bone/voxmap/sparse_bricks.h"

namespace reamsim {

/// Sets the voxels of one brick, which begins as air; says whether it set any. Where it says no, it must have left the
/// brick as it was. Called from several threads at once, each with a brick of its own.
using BrickSampler = std::function<bool(const Vec3i& brick_coord, GradeBricks::Brick& brick)>;

/// The grades of a lattice of `dims` voxels, sampled brick by brick in parallel. The result does not depend on the
/// threads.
GradeBricks sample_bricks(const Vec3i& dims, const BrickSampler& sample);

}  // namespace reamsim
