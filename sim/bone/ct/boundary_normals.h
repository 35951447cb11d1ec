#pragma once

#include "sim/bone/ct/aligned_image.h"
#include "sim/bone/ct/morphology.h"

namespace reamsim::ct {

/// Which way bone lies from a voxel near its boundary: the gradient of the mask after a Gaussian, which takes the steps
/// of the voxels off it.
class BoundaryNormals {
 public:
  BoundaryNormals(const Mask& bone, const Lattice& lattice);

  /// Unit vector in mm, LPS; zero where the mask is even all round.
  [[nodiscard]] Vec3 inward(const Vec3i& voxel) const;

 private:
  AlignedImage smooth_;
};

}  // namespace reamsim::ct
