#pragma once

#include "sim/base/report.h"
#include "sim/bone/ct/morphology.h"

namespace reamsim::ct {

/// |HU − threshold|, positive in `bone` and negative outside.
std::vector<float> signed_field(const AlignedImage& hu, double threshold_hu, const Mask& bone);

/// Moves the surface of a mask to the isosurface of the HU where that lies within `reach_mm` along the normal. `field`
/// is above 0 in the mask; afterwards it is signed_field() of the refined mask. A voxel outside the mask becomes bone
/// if all points between it and the mask are dense and the density ends within reach. A voxel inside becomes air if all
/// points between it and the surface are not dense and bone begins within reach. So trabecular bone under a cortex is
/// kept, a joint gap is not crossed, and voxels of the `other` labels are never added.
void refine_to_isosurface(AlignedImage& field, const AlignedImage& other, const AlignedImage& hu, double threshold_hu,
                          double reach_mm, Report& report);

}  // namespace reamsim::ct
