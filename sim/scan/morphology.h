// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "sim/scan/aligned_image.h"

namespace reamsim::ct {

/// A set of voxels on the lattice of an image: 1 inside, 0 outside.
using Mask = std::vector<std::uint8_t>;

/// The voxels with a value above 0.
Mask positive_voxels(const AlignedImage& image);
Mask complement(const Mask& mask);
/// The voxels whose box of ±`radius` voxels lies in the mask. Beyond the image the values of its border hold.
Mask eroded(const Mask& mask, const Lattice& lattice, const Vec3i& radius);
/// The voxels whose box of ±`radius` voxels meets the mask.
Mask dilated(const Mask& mask, const Lattice& lattice, const Vec3i& radius);

/// A connected component; its voxels share faces.
struct Piece {
  std::uint32_t label = 0;  ///< in the label image: 1 for the largest piece, then by size
  std::int64_t voxels = 0;
  Vec3i min = Vec3i::Constant(std::numeric_limits<int>::max());  ///< first and last voxel of its bounding box
  Vec3i max = Vec3i::Constant(-1);

  void add(const Vec3i& voxel) {
    ++voxels;
    min = min.cwiseMin(voxel);
    max = max.cwiseMax(voxel);
  }
};

/// The voxels from `first` to `last` with a margin, within the image.
IndexBox box_around(const Vec3i& first, const Vec3i& last, const Vec3i& margin, const Lattice& lattice);

/// The part of the values of an image in a box.
template <class Value>
std::vector<Value> part_of(const std::vector<Value>& values, const Lattice& lattice, const IndexBox& box) {
  std::vector<Value> out;
  out.reserve(static_cast<std::size_t>(box.voxels()));
  for_each_voxel(box.size, [&](const Vec3i& voxel) { out.push_back(values[lattice.index(voxel + box.start)]); });
  return out;
}

struct Pieces {
  std::vector<std::uint32_t> label;  ///< 0 outside
  std::vector<Piece> list;           ///< list[n] has label n+1
};

/// Median over a box of (2·radius+1)³ voxels.
void median_filter(AlignedImage& image, int radius_voxels);

/// Curvature anisotropic diffusion (Whitaker and Xue 2001), ITK's filter with its largest stable time step.
void curvature_anisotropic_filter(AlignedImage& image, int iterations, double conductance);

void gaussian_filter(AlignedImage& image, double sigma_voxels);

Pieces connected_pieces(const Mask& mask, const Lattice& lattice);

/// Morphological closing by a ball of `radius_mm`, rounded to voxels along each axis.
void close_mask(Mask& mask, const Lattice& lattice, double radius_mm);

/// Fills the holes of the mask and returns the number of voxels filled. A part of the background that the mask encloses
/// within a face of the image is a hole: a bone that extends beyond the image keeps its interior.
std::int64_t fill_holes(Mask& mask, const Lattice& lattice);

}  // namespace reamsim::ct
