// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/bench/scene.h"

namespace reamsim::bench::sphere {

// The plunged sphere: a cap that a spherical tool cuts along z into the flat face of a block. Frame B: face at z = 0,
// +z out of the bone.
inline constexpr double kRadiusMm = 29;
inline constexpr double kDepthMm = 4;  ///< of the whole plunge
inline constexpr double kSphereFeedMmS = 0.2;
inline constexpr double kSphereFrameS = 1e-3;

/// A block of uniform bone under the sphere, offset from the tool's axis by fractions of a voxel so that nothing is
/// regular.
FilledVoxmap block(double voxel_mm);

/// The tool: a cap of the sphere with a cylinder above it, and the shell that `reamsim run` chooses, of at most 1024³
/// cells.
Tool cap(double voxel_mm);

/// The substep of a frame that ends at `depth_mm`, at the plunge's feed rate and 250 rpm. `number`: of the frame.
Substep down_to(double depth_mm, std::int64_t number);

}  // namespace reamsim::bench::sphere
