// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>

#include "sim/scan/aligned_image.h"
#include "sim/scan/segment.h"

namespace reamsim::ct {

struct BoundaryDensity {
  std::int64_t boundary_voxels = 0;  ///< bone voxels with a face neighbour outside the bone
  std::int64_t unresolved_voxels =
      0;                ///< of these, voxels whose density is a lower bound: no trusted voxel, or a plate
  double noise_hu = 0;  ///< standard deviation between neighbouring trusted voxels

  [[nodiscard]] double unresolved_fraction() const {
    return boundary_voxels == 0 ? 0 : static_cast<double>(unresolved_voxels) / static_cast<double>(boundary_voxels);
  }
};

/// Corrects the radiodensity of voxels at the boundary of the bone for partial volume, on the lattice of the scan and
/// before any resampling.
///
/// A voxel is *trusted* if all voxels within the point spread around it are bone, so that its value is that of bone
/// alone. Trusted values are extrapolated linearly along the outward normal (Aslam 2004, J. Comput. Phys. 193:349, §2:
/// multidimensional extrapolation), with the smaller of two consecutive slopes (minmod). Each value is a mean over nine
/// points across the normal. The result is limited to the largest value measured within two voxels below the boundary,
/// so that a dense plate over soft bone does not overshoot. If a measured value exceeds the extrapolation by more than
/// three standard deviations of the noise, or no trusted voxel lies below, the scan does not resolve the cortex: then
/// the largest measured value is used, as a lower bound. A corrected value never exceeds a measured one.
///
/// Voxels outside the bone get values as well, `reach_voxels` deep, for interpolation and averaging at the boundary.
/// @param hu           the scan, HU; corrected in place
/// @param bone         on the lattice of `hu`; above 0 in bone, including adjacent bone that a cut removed
/// @param psf_mm       full width of the scanner's point spread along each axis of LPS, mm; 0: the voxel spacing
/// @param reach_voxels how far from the bone resampling reads, at least 2
BoundaryDensity correct_boundary(AlignedImage& hu, const BoneField& bone, const Vec3& psf_mm, int reach_voxels);

}  // namespace reamsim::ct
