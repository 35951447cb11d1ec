#pragma once

#include <cstdint>

#include "sim/bone/ct/aligned_image.h"
#include "sim/bone/ct/segment.h"

namespace reamsim::ct {

/// What correct_boundary() found.
struct BoundaryDensity {
  std::int64_t boundary_voxels = 0;    ///< bone voxels that share a face with a voxel outside
  std::int64_t unresolved_voxels = 0;  ///< of these, where the density is a lower bound: no trusted voxel, or a plate
  double noise_hu = 0;                 ///< standard deviation between neighbouring trusted voxels

  [[nodiscard]] double unresolved_fraction() const {
    return boundary_voxels == 0 ? 0 : static_cast<double>(unresolved_voxels) / static_cast<double>(boundary_voxels);
  }
};

/// Replaces the radiodensity of voxels at the bone's boundary, which mix bone with what lies beside it (partial
/// volume), by that of the bone, on the lattice of the scan and before any resampling.
///
/// A voxel is *trusted* when every voxel within the point spread round it is bone: then no part of its own point spread
/// reaches outside, wherever between the voxels the boundary lies. Trusted values are extrapolated linearly along the
/// outward normal (Aslam 2004, J. Comput. Phys. 193:349, §2: multidimensional extrapolation), with the smaller of two
/// consecutive slopes (minmod), each value a mean over nine places across the normal. The result is limited to
/// the largest value measured within two voxels below the boundary, so that a dense plate over soft bone does not
/// overshoot. Where a measured value exceeds the extrapolation by more than the noise, or no trusted voxel lies below,
/// the bone is denser than what the scan resolves: then that largest value stands, a lower bound.
///
/// Noise: a corrected value is an average or a measured value, and never exceeds a measured one. The extrapolation is
/// preferred to a measured value that is less than three standard deviations higher.
///
/// Voxels outside the bone get values as well, `reach_voxels` deep, for interpolation and averaging at the boundary.
/// @param hu           the scan, HU; corrected in place
/// @param bone         on the lattice of `hu`; above 0 counts as bone, bone beside it that a cut removed included
/// @param psf_mm       full width of the scanner's point spread, mm; 0: the voxel spacing along each axis
/// @param reach_voxels how far from the bone resampling reads, at least 2
BoundaryDensity correct_boundary(AlignedImage& hu, const BoneField& bone, double psf_mm, int reach_voxels);

}  // namespace reamsim::ct
