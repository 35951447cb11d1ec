#pragma once

#include <cstdint>
#include <vector>

#include "sim/bone/ct/aligned_image.h"

namespace reamsim::ct {

/// A voxel set on the lattice of an image: 1 = in, 0 = out.
using Mask = std::vector<std::uint8_t>;

/// One connected piece (voxels that share faces).
struct Piece {
  std::uint32_t label = 0;  ///< in the label image; pieces are numbered from 1, the largest first
  std::int64_t voxels = 0;
  Vec3i min = Vec3i::Zero();  ///< corners of its bounding box, both inside
  Vec3i max = Vec3i::Zero();
};

struct Pieces {
  std::vector<std::uint32_t> label;  ///< 0 = out
  std::vector<Piece> list;           ///< list[n] has label n+1
};

/// Median over a box of (2·radius+1)³ voxels.
void median_filter(AlignedImage& image, int radius_voxels);

/// Curvature anisotropic diffusion (Whitaker and Xue 2001), ITK's filter with its largest stable time step.
void curvature_anisotropic_filter(AlignedImage& image, int iterations, double conductance);

/// Gaussian of the given width in voxels.
void gaussian_filter(AlignedImage& image, double sigma_voxels);

Pieces connected_pieces(const Mask& mask, const Lattice& lattice);

/// Morphological closing by a ball of `radius_mm`, rounded to voxels along each axis.
void close_mask(Mask& mask, const Lattice& lattice, double radius_mm);

/// Fills what the mask encloses. On a face of the image, what the mask encloses within that face counts as enclosed:
/// a bone that leaves the image does not lose its inside. Returns the number of voxels filled.
std::int64_t fill_holes(Mask& mask, const Lattice& lattice);

}  // namespace reamsim::ct
