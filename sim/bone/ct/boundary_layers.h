#pragma once

#include "sim/bone/ct/aligned_image.h"
#include "sim/bone/ct/morphology.h"

namespace reamsim::ct {

/// The voxels whose box of ±`radius` voxels lies wholly in the mask. What lies beyond the image counts as its border.
Mask eroded(const Mask& mask, const Lattice& lattice, const Vec3i& radius);
/// The voxels whose box of ±`radius` voxels meets the mask.
Mask dilated(const Mask& mask, const Lattice& lattice, const Vec3i& radius);

/// Standard deviation of the noise among the voxels of a mask: from the median of the absolute second differences along
/// each axis (as Immerkær 1996, Comput. Vis. Image Underst. 64:300, with a median, which edges do not move). 0 where
/// fewer than 30 voxels have two neighbours.
double noise_between(const AlignedImage& image, const Mask& mask);

/// Gives voxels round the `known` ones the mean of their known neighbours (of 26), `layers` times, and marks them.
void spread_outwards(AlignedImage& image, Mask& known, int layers);

}  // namespace reamsim::ct
