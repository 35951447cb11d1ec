// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/base/error.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scan/aligned_image.h"
#include "sim/scan/humeral_head.h"
#include "sim/scan/scan.h"
#include "sim/scan/segmentation.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Converts a CT scan (DICOM folder, NRRD, NIfTI, MetaImage) to a voxmap in LPS mm: crop, filter, threshold, closing,
/// hole filling, cuts, the piece with the seed; or a label map. HU are resampled to `settings.voxel_mm` by averages or
/// by trilinear interpolation (paper §3.2), then mapped to grades. `segmentation`, if not null, is filled. Throws
/// InputError: unreadable, truncated, absurdly large, no bone in the crop, seed outside bone.
FilledVoxmap voxmap_from_ct(const BoneSettings& settings, Diagnostics& report, Segmentation* segmentation = nullptr,
                            const StageSink& stages = {});

/// The same for an open scan; `settings.ct.path` is its name in messages.
FilledVoxmap voxmap_from_scan(const ct::ScanSource& source, const BoneSettings& settings, Diagnostics& report,
                              Segmentation* segmentation = nullptr, const StageSink& stages = {});

/// A scan as the segmentation sees it, before it is resampled: for looking at it.
struct SegmentedScan {
  ct::AlignedImage hu;            ///< cropped and filtered
  std::vector<float> field;       ///< per voxel, above 0 in the bone; empty where the segmentation failed
  CtSettings settings;            ///< with the cut of `separate`, and its seed
  std::vector<Mistake> mistakes;  ///< why it failed
};

/// Reads, crops, filters and segments a scan as voxmap_from_ct() does. A segmentation that fails (no bone above the
/// threshold, a seed outside the bone) is no error: the scan is returned without it. Throws InputError: unreadable,
/// truncated, absurdly large, an empty crop.
/// `voxmap`, if not null, becomes what voxmap_from_ct() makes of it, where the segmentation succeeds.
SegmentedScan segmented_scan(const BoneSettings& settings, Diagnostics& report,
                             std::optional<FilledVoxmap>* voxmap = nullptr);

/// The joints of a scan, the clearest first (ct::find_joints()). Crop and filter of the settings apply. Throws
/// InputError as segmented_scan() does.
std::vector<ct::Joint> joints_in_scan(const BoneSettings& settings, Diagnostics& report);

}  // namespace reamsim
