// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <string>
#include <vector>

namespace reamsim::ct {

/// A value of a label map and its layer.
struct LabelValue {
  int layer = 0;
  double value = 1;
};

struct NamedSegment {
  std::string name;
  LabelValue label;
};

/// The named segments of a .seg.nrrd (SegmentN_Name, SegmentN_Layer, SegmentN_LabelValue), in their order. Files
/// without these keys have one segment per layer, of value 1.
std::vector<NamedSegment> segments_of_nrrd(const std::map<std::string, std::string>& metadata, int layers);

/// The named labels in an XML extension of a NIfTI file, `<Label Key="7" ...>name</Label>`, as TotalSegmentator writes.
std::vector<NamedSegment> segments_of_nifti(const std::string& path);

/// The labels for `wanted`: a whole number is a value, anything else a name (a to z as A to Z).
/// Throws InputError: an unknown name, a number that occurs in several layers.
std::vector<LabelValue> find_labels(const std::vector<std::string>& wanted, const std::vector<NamedSegment>& segments,
                                    int layers, const std::string& path);

/// "scapula_left, 7".
std::string words_of_labels(const std::vector<std::string>& labels);

}  // namespace reamsim::ct
