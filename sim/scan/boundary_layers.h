// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/scan/morphology.h"

namespace reamsim::ct {

/// Normals of the boundary of a mask: the gradient of the mask after a Gaussian filter, which smooths the voxel steps.
class BoundaryNormals {
 public:
  BoundaryNormals(const Mask& bone, const Lattice& lattice);

  /// Unit vector into the bone, LPS; zero where the mask is uniform.
  [[nodiscard]] Vec3 inward(const Vec3i& voxel) const;

 private:
  AlignedImage smooth_;
};

/// Standard deviation of the noise among the voxels of a mask: from the median of the absolute second differences along
/// each axis (as Immerkær 1996, Comput. Vis. Image Underst. 64:300, with a median, which edges do not affect). 0 where
/// fewer than 30 voxels have two neighbours.
double noise_between(const AlignedImage& image, const Mask& mask);

/// Extends the `known` voxels by `layers` layers. A new voxel gets the mean of its known neighbours (of 26).
void spread_outwards(AlignedImage& image, Mask& known, int layers);

}  // namespace reamsim::ct
