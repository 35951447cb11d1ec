#pragma once

#include "sim/bone/ct/segment.h"

namespace reamsim::ct {

/// The axial, coronal and sagittal plane of an image through a point of B, with the bone's field: what a person looks
/// at to judge a segmentation. A point outside the image is moved to its nearest voxel. Cuts count as outside.
std::vector<ScanPlane> scan_planes(const AlignedImage& hu, const BoneField& bone, const CtSettings& settings,
                                   const Vec3& through_mm);

}  // namespace reamsim::ct
