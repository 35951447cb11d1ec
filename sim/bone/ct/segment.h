#pragma once

#include <string>

#include "sim/base/report.h"
#include "sim/bone/ct/aligned_image.h"
#include "sim/bone/ct/label_map.h"
#include "sim/bone/ct/morphology.h"
#include "sim/bone/ct/segmentation.h"
#include "sim/scenario/scenario.h"

namespace reamsim::ct {

/// Bone in an image, with a surface finer than its voxels: `field` is above 0 in bone and its zero lies where the bone
/// ends. `cuts` are applied again after resampling, so that they are as smooth as the voxmap allows.
struct BoneField {
  AlignedImage field;
  std::int64_t voxels = 0;        ///< in bone
  std::int64_t inside_below = 0;  ///< of these, below the threshold: trabecular bone and marrow
  Vec3i min = Vec3i::Zero();      ///< corners of the bone's bounding box, both inside
  Vec3i max = Vec3i::Zero();
  Segmentation facts;  ///< all but the planes
};

/// Whether a cut sphere or plane takes this point away.
bool is_cut_away(const CtSettings& settings, const Vec3& point_mm);

/// Threshold, cuts, the piece with the seed, closing, hole filling.
///
/// The piece is chosen before closing, so that closing never bridges a joint to the next bone; and the seed may lie in
/// the trabecular inside, since a piece is judged as it is when closed and filled.
/// The field is |HU − threshold| with the sign of the mask: where the threshold made the surface its zero is the
/// isosurface of the interpolated HU, and where closing or a piece's end made it, it lies halfway between voxels.
/// Throws InputError: nothing above the threshold, all of it cut away, seed outside the crop or outside bone.
BoneField segment_by_threshold(const AlignedImage& hu, const CtSettings& settings, Report& report);

/// The field is the labels' share after a slight Gaussian, minus a half, because a bare 0/1 step shows the voxels as
/// stairs; or, on request, what refine_to_isosurface() makes of it.
/// Throws InputError when no voxel has the label.
BoneField segment_by_label(LabelImages labels, const AlignedImage& hu, const CtSettings& settings, Report& report);

}  // namespace reamsim::ct
