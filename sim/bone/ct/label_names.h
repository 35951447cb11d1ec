#pragma once

#include <map>
#include <string>
#include <vector>

namespace reamsim::ct {

/// A value of a label map, and the layer in which it stands.
struct LabelValue {
  int layer = 0;
  double value = 1;
};

/// A named segment of a label map.
struct NamedSegment {
  std::string name;
  LabelValue label;
};

/// The segments that a .seg.nrrd names (SegmentN_Name, SegmentN_Layer, SegmentN_LabelValue), in their order. Files
/// older than the layers have one segment per layer, of value 1.
std::vector<NamedSegment> segments_of_nrrd(const std::map<std::string, std::string>& metadata, int layers);

/// The labels that a NIfTI file names in an XML extension: <Label Key="7" ...>name</Label>, as TotalSegmentator writes.
std::vector<NamedSegment> segments_of_nifti(const std::string& path);

/// The labels that `wanted` stands for: a whole number is a value, anything else a name, case aside.
/// Throws InputError: a name that the map does not have, a number that stands in several layers.
std::vector<LabelValue> find_labels(const std::vector<std::string>& wanted, const std::vector<NamedSegment>& segments,
                                    int layers, const std::string& path);

/// "scapula_left, 7".
std::string words_of_labels(const std::vector<std::string>& labels);

}  // namespace reamsim::ct
