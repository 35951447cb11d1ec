#pragma once

#include "sim/base/report.h"
#include "sim/bone/ct/label_map.h"

namespace reamsim::ct {

/// Moves the surface of a mask to the isosurface of the HU where that lies within `reach_mm` along the surface's
/// normal. `field` is above 0 in the mask; afterwards it is |HU − threshold| with the sign of the refined mask, so that
/// its zero is the isosurface as it is after segment_by_threshold(). A voxel outside the mask becomes bone where all is
/// dense from the mask to it and the density ends within reach; a voxel inside becomes air where nothing is dense from
/// it out to the mask's surface and bone begins within reach. So trabecular bone under a cortex stays, a joint gap is
/// not crossed, and voxels with another label are never taken.
void refine_to_isosurface(AlignedImage& field, const AlignedImage& other, const AlignedImage& hu, double threshold_hu,
                          double reach_mm, Report& report);

}  // namespace reamsim::ct
