// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
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

/// Reads the map of the scenario, finds the wanted labels and resamples them to the voxels of `hu`, which were read
/// from the voxels `box` of `image`. Warns if the map ends inside the bone.
/// Throws InputError: unreadable, no such label, no overlap of map and image.
LabelImages read_labels(const CtSettings& settings, const ScanGeometry& image, const IndexBox& box,
                        const AlignedImage& hu, Diagnostics& report);

}  // namespace reamsim::ct
