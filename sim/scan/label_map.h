// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scan/aligned_image.h"
#include "sim/scenario/scenario.h"

namespace reamsim::ct {

/// The named segments of a .seg.nrrd (SegmentN_Name, SegmentN_Layer, SegmentN_LabelValue), in their order. Files
/// without these keys have one segment per layer, of value 1.
std::vector<NamedSegment> segments_of_nrrd(const std::map<std::string, std::string>& metadata, int layers);

/// The named labels in the XML extensions of a NIfTI file, `<Label Key="7" ...>name</Label>`, as TotalSegmentator
/// writes.
std::vector<NamedSegment> segments_of_nifti(const std::vector<std::string>& extensions);

/// The labels for `wanted`: a whole number is a value, anything else a name (a to z as A to Z).
/// Throws InputError: an unknown name, a number that occurs in several layers.
std::vector<LabelValue> find_labels(const std::vector<std::string>& wanted, const std::vector<NamedSegment>& segments,
                                    int layers, const std::string& path);

/// "scapula_left, 7".
std::string words_of_labels(const std::vector<std::string>& labels);

/// A label map on the lattice of a CT.
struct LabelImages {
  AlignedImage selected;  ///< 1 in voxels with one of the wanted labels, 0 elsewhere
  AlignedImage other;     ///< 1 in voxels with another label of the same layer
};

/// The nearest voxel of a label map to a voxel of an image, in patient space. Halfway points, to within a tolerance,
/// belong to the voxel further along LPS, so that the result does not depend on the storage order of the map.
class NearestVoxel {
 public:
  NearestVoxel(const ScanGeometry& labels, const ScanGeometry& image);

  [[nodiscard]] Vec3i operator()(const Vec3i& voxel) const {
    const Vec3 at = first_ + step_ * voxel.cast<double>();
    Vec3i out;
    for (int axis = 0; axis < 3; ++axis) {
      const double up = std::floor(at[axis] + 0.5 + kTie_voxels);
      const double down = std::ceil(at[axis] - 0.5 - kTie_voxels);
      out[axis] = static_cast<int>(std::clamp(forward_[axis] ? up : down, -1.0, last_[axis] + 1));
    }
    return out;
  }

 private:
  static constexpr double kTie_voxels = 0.01;  ///< tolerance of a halfway point

  Mat3 step_;   ///< a step in the image, in voxels of the map
  Vec3 first_;  ///< the first voxel of the image, in voxels of the map
  Vec3 last_;
  bool forward_[3] = {true, true, true};  ///< whether an axis of the map has the direction of LPS
};

/// Reads the map of the scenario, finds the wanted labels and resamples them to the voxels of `hu`, which were read
/// from the voxels `box` of `image`. Warns if the map ends inside the bone.
/// Throws InputError: unreadable, no such label, no overlap of map and image.
LabelImages read_labels(const CtSettings& settings, const ScanGeometry& image, const IndexBox& box,
                        const AlignedImage& hu, Diagnostics& report);

}  // namespace reamsim::ct
