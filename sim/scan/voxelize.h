// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/base/error.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scan/aligned_image.h"
#include "sim/scan/segment.h"
#include "sim/scenario/scenario.h"

namespace reamsim::ct {

/// Distance from the bone at which resampling to voxels of `voxel_mm` reads values, image voxels.
int resampling_reach(const Lattice& image, double voxel_mm);

/// Resamples HU and bone to voxels of `settings.voxel_mm`, with a margin of air in whole bricks, and maps HU to grades.
/// Throws InputError: too many voxels for this machine, or voxels so large that no bone remains.
FilledVoxmap voxelize(const AlignedImage& hu, const BoneField& bone, const BoneSettings& settings, Diagnostics& report);

}  // namespace reamsim::ct
