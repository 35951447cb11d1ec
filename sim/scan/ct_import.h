// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <vector>

#include "sim/base/error.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scan/aligned_image.h"
#include "sim/scan/scan.h"
#include "sim/scan/segmentation.h"
#include "sim/scenario/scenario.h"

namespace reamsim::ct {

/// In LPS, mm.
struct Sphere {
  Vec3 center_mm = Vec3::Zero();
  double radius_mm = 0;
};

/// The head of the humerus in a scan, the sphere that fits its surface, and the one that cuts it off through the joint
/// gap. LPS, mm.
struct HumeralHead : Sphere {
  double rms_mm = 0;             ///< of the points of the surface near that sphere
  double cut_radius_mm = 0;      ///< through the least radiodensity between head and glenoid
  double touching_fraction = 0;  ///< of the directions towards the glenoid: no voxel of the gap is below the threshold
};

/// Finds the head next to a point near the centre of the glenoid's face. Surface points vote for centres along their
/// inward normals (Ballard 1981, Pattern Recognition 13, 111–122: the generalized Hough transform); a sphere is then
/// fitted to those that face away from the centre, and the cut is chosen by the mean radiodensity over spheres round
/// it. nullopt where no sphere of 16 to 32 mm radius is next to the point.
std::optional<HumeralHead> find_humeral_head(const AlignedImage& hu, double threshold_hu, const Vec3& near_mm);

/// A head that faces another bone across a gap. LPS, mm.
struct Joint {
  HumeralHead head;             ///< without its cut
  Vec3 near_mm = Vec3::Zero();  ///< a point on the face opposite to the head
  double gap_fraction = 0;      ///< of the cap of the head towards it: bone follows behind a gap
};

/// Searches a whole scan for heads of 16 to 32 mm radius, each with the face opposite to it: in the same way, with
/// votes for all places. Those with the clearest gap come first. A hip is such a joint too.
std::vector<Joint> find_joints(const AlignedImage& hu, double threshold_hu);

}  // namespace reamsim::ct

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
