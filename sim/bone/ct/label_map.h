#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "sim/base/report.h"
#include "sim/bone/ct/aligned_image.h"
#include "sim/bone/ct/label_names.h"
#include "sim/scenario/scenario.h"

namespace reamsim::ct {

/// A label map on the lattice of a CT.
struct LabelImages {
  AlignedImage selected;  ///< 1 in voxels with one of the wanted labels, 0 elsewhere
  AlignedImage other;     ///< 1 in voxels with another label of the same layer; empty unless the mask is to be refined
};

/// The voxel of a label map nearest to each voxel of an image, in patient space. Points halfway between two voxels go
/// to the one further along LPS, however the map is stored, and with a tolerance for coordinates that carry rounding.
class NearestVoxel {
 public:
  NearestVoxel(const ScanGeometry& labels, const ScanGeometry& image);

  [[nodiscard]] Vec3i operator()(int i, int j, int k) const {
    const Vec3 at = first_ + step_ * Vec3(i, j, k);
    Vec3i out;
    for (int axis = 0; axis < 3; ++axis) {
      const double up = std::floor(at[axis] + 0.5 + kTie_voxels);
      const double down = std::ceil(at[axis] - 0.5 - kTie_voxels);
      out[axis] = static_cast<int>(std::clamp(forward_[axis] ? up : down, -1.0, last_[axis] + 1));
    }
    return out;
  }

 private:
  /// Places closer than this to halfway are halfway.
  static constexpr double kTie_voxels = 0.01;

  Mat3 step_;   ///< of a step in the image, in voxels of the map
  Vec3 first_;  ///< where the image's first voxel lies in the map
  Vec3 last_;
  bool forward_[3] = {true, true, true};  ///< whether an axis of the map runs along LPS
};

/// Reads the map of the scenario, finds the wanted labels and resamples them to the voxels of `hu`, which were read
/// from the voxels `box` of `image`.
/// Throws InputError: unreadable, no such label, a map that does not meet the image (with both boxes).
/// Warns where the map ends inside the bone.
LabelImages read_labels(const CtSettings& settings, const ScanGeometry& image, const IndexBox& box,
                        const AlignedImage& hu, Report& report);

}  // namespace reamsim::ct
