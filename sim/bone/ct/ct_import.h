#pragma once

#include "sim/base/report.h"
#include "sim/bone/ct/scan.h"
#include "sim/bone/ct/segmentation.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// A CT scan (DICOM folder, NRRD, NIfTI, MetaImage) to a voxmap in LPS mm: crop, filter, threshold, closing, hole
/// filling, cuts, the piece with the seed; or a label map instead. HU are resampled to `settings.voxel_mm` by averaging
/// when merging and trilinearly when dividing (paper §3.2), then mapped to density and grade.
/// Throws InputError: unreadable, truncated, absurdly large, no bone in the crop, seed outside bone.
/// `segmentation`, where it is asked for, gets what was done, with pictures' planes through the seed.
FilledVoxmap voxmap_from_ct(const BoneSettings& settings, Report& report, Segmentation* segmentation = nullptr);

/// The same for a scan that is open; `settings.ct.path` only names it in messages.
FilledVoxmap voxmap_from_scan(const ct::ScanSource& source, const BoneSettings& settings, Report& report,
                              Segmentation* segmentation = nullptr);

}  // namespace reamsim
