// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "sim/base/error.h"
#include "sim/scan/aligned_image.h"
#include "sim/scan/label_map.h"
#include "sim/scan/morphology.h"
#include "sim/scan/segmentation.h"
#include "sim/scenario/scenario.h"

namespace reamsim::ct {

/// Bone in an image, with a surface of subvoxel accuracy: `field` is above 0 in bone and 0 at the surface. Cuts are
/// applied again after resampling, to be as accurate as the voxmap allows.
struct BoneField {
  AlignedImage field;
  std::int64_t voxels = 0;        ///< of bone
  std::int64_t inside_below = 0;  ///< of these, below the threshold: trabecular bone and marrow
  Vec3i min = Vec3i::Zero();      ///< first and last voxel of the bone's bounding box
  Vec3i max = Vec3i::Zero();
  Segmentation facts;  ///< without the planes
};

/// Whether a cut sphere or plane removes this point.
bool is_cut_away(const CtSettings& settings, const Vec3& point_mm);

/// Threshold, cuts, the piece with the seed, closing, hole filling.
///
/// The piece is chosen before closing, so that closing never bridges a joint to the next bone. The seed may lie in
/// trabecular bone, because each piece is closed and filled for that test.
/// The field is signed_field(). Where the threshold determines the surface, its zero is the isosurface of the
/// interpolated HU; elsewhere it lies halfway between voxels.
/// Throws InputError: nothing above the threshold, all bone cut away, seed outside the crop or outside bone.
BoneField segment_by_threshold(const AlignedImage& hu, const CtSettings& settings, Diagnostics& report);

/// The field is the mask of the labels after a narrow Gaussian, which smooths the voxel steps, minus a half; with
/// `refine_mm` the result of refine_to_isosurface().
/// Throws InputError when no voxel has the label.
BoneField segment_by_label(LabelImages labels, const AlignedImage& hu, const CtSettings& settings, Diagnostics& report);

/// |HU − threshold|, positive in `bone` and negative outside.
std::vector<float> signed_field(const AlignedImage& hu, double threshold_hu, const Mask& bone);

/// Moves the surface of a mask to the isosurface of the HU where that lies within `reach_mm` along the normal. `field`
/// is above 0 in the mask; afterwards it is signed_field() of the refined mask. A voxel outside the mask becomes bone
/// if all points between it and the mask are dense and the density ends within reach. A voxel inside becomes air if all
/// points between it and the surface are not dense and bone begins within reach. So trabecular bone under a cortex is
/// kept, a joint gap is not crossed, and voxels of the `other` labels are never added.
void refine_to_isosurface(AlignedImage& field, const AlignedImage& other, const AlignedImage& hu, double threshold_hu,
                          double reach_mm, Diagnostics& report);

}  // namespace reamsim::ct
