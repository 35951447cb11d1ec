// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/label_map.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>

#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim::ct {

namespace {

constexpr const char* kLabelChoiceKey = "bone.ct.label_map.label";
/// Names that a message lists; TotalSegmentator has 117.
constexpr std::size_t kMaxNames = 40;

/// Marks an invalid number. No map has so many layers, so its segment is rejected as damaged.
constexpr int kNoWholeNumber = 1'000'000;

/// A whole number of the metadata; `otherwise` if it is missing, kNoWholeNumber if it is invalid.
int whole_number_or(const std::map<std::string, std::string>& metadata, const std::string& key, int otherwise) {
  const auto found = metadata.find(key);
  if (found == metadata.end()) return otherwise;
  const std::string text = found->second.substr(0, found->second.find_last_not_of(" \t\r") + 1);
  if (!is_whole_number(text)) return kNoWholeNumber;
  return static_cast<int>(std::min(std::strtod(text.c_str(), nullptr), double{kNoWholeNumber}));
}

std::string names_of(const std::vector<NamedSegment>& segments) {
  std::string out;
  for (std::size_t n = 0; n < std::min(segments.size(), kMaxNames); ++n) {
    out += (n == 0 ? "" : ", ") + printable(segments[n].name);
  }
  if (segments.size() > kMaxNames) out += ", and " + std::to_string(segments.size() - kMaxNames) + " more";
  return out;
}

LabelValue find_name(const std::string& wanted, const std::vector<NamedSegment>& segments, const std::string& path) {
  std::vector<LabelValue> found;
  for (const NamedSegment& segment : segments) {
    if (lower_case(segment.name) == lower_case(wanted)) found.push_back(segment.label);
  }
  if (found.size() == 1) return found.front();
  if (found.size() > 1) {
    throw InputError({path}, kLabelChoiceKey, "'" + wanted + "' names " + std::to_string(found.size()) + " segments",
                     "rename one of them; the map has " + names_of(segments));
  }
  if (segments.empty()) {
    throw InputError({path}, kLabelChoiceKey, "'" + wanted + "', but the label map names no segments",
                     "give the label's number, or a .seg.nrrd with SegmentN_Name");
  }
  throw InputError({path}, kLabelChoiceKey, "no segment is named '" + wanted + "'",
                   "expected one of " + names_of(segments) + ", or a label's number");
}

/// A number that is also the name of a segment with another number may mean either.
void refuse_ambiguous(const std::string& wanted, const std::vector<NamedSegment>& segments, const std::string& path) {
  const double value = std::strtod(wanted.c_str(), nullptr);
  const auto other = std::ranges::find_if(
      segments, [&](const NamedSegment& segment) { return segment.name == wanted && segment.label.value != value; });
  if (other == segments.end()) return;
  throw InputError({path}, kLabelChoiceKey,
                   fmt::format("'{0}' is ambiguous: label {0}, or the segment named '{0}', whose label is {1:.0f}",
                               wanted, other->label.value),
                   "rename that segment");
}

LabelValue find_number(const std::string& wanted, const std::vector<NamedSegment>& segments, int layers,
                       const std::string& path) {
  const double value = std::strtod(wanted.c_str(), nullptr);
  if (value == 0) {
    throw InputError({path}, kLabelChoiceKey, "label 0 is the background", "expected a label above 0, or a name");
  }
  refuse_ambiguous(wanted, segments, path);
  if (layers == 1) return {0, value};
  std::vector<NamedSegment> found;
  std::ranges::copy_if(segments, std::back_inserter(found),
                       [value](const NamedSegment& segment) { return segment.label.value == value; });
  if (found.size() == 1) return found.front().label;
  const std::string in_layers = " of a label map with " + std::to_string(layers) + " layers";
  if (segments.empty()) {
    throw InputError({path}, kLabelChoiceKey, "label " + wanted + in_layers + ", none of them named",
                     "expected one number in each voxel, or SegmentN_Name, SegmentN_Layer and SegmentN_LabelValue");
  }
  if (found.empty()) {
    throw InputError({path}, kLabelChoiceKey, "no segment has label " + wanted,
                     "choose a segment by its name: " + names_of(segments));
  }
  throw InputError({path}, kLabelChoiceKey,
                   "label " + wanted + " stands for " + std::to_string(found.size()) + " segments" + in_layers,
                   "choose one by its name: " + names_of(found));
}

/// The value of attribute `name` in the opening tag `tag`; "" if it is missing.
std::string attribute(const std::string& tag, const std::string& name) {
  const std::size_t at = tag.find(name + "=\"");
  if (at == std::string::npos) return "";
  const std::size_t from = at + name.size() + 2;
  const std::size_t end = tag.find('"', from);
  return end == std::string::npos ? "" : tag.substr(from, end - from);
}

}  // namespace

std::vector<NamedSegment> segments_of_nrrd(const std::map<std::string, std::string>& metadata, int layers) {
  std::vector<NamedSegment> out;
  for (int n = 0;; ++n) {
    const std::string prefix = "Segment" + std::to_string(n) + "_";
    const auto id = metadata.find(prefix + "ID");
    auto name = metadata.find(prefix + "Name");
    if (name == metadata.end()) name = id;
    if (name == metadata.end()) break;
    const int layer = whole_number_or(metadata, prefix + "Layer", layers > 1 ? n : 0);
    const int value = whole_number_or(metadata, prefix + "LabelValue", 1);
    out.push_back({name->second, {value == kNoWholeNumber ? kNoWholeNumber : layer, static_cast<double>(value)}});
  }
  return out;
}

std::vector<NamedSegment> segments_of_nifti(const std::vector<std::string>& extensions) {
  std::vector<NamedSegment> out;
  for (const std::string& xml : extensions) {
    for (std::size_t at = xml.find("<Label "); at != std::string::npos; at = xml.find("<Label ", at + 1)) {
      const std::size_t open_end = xml.find('>', at);
      const std::size_t close = xml.find("</Label>", at);
      if (open_end == std::string::npos || close == std::string::npos || open_end > close) break;
      const std::string key = attribute(xml.substr(at, open_end - at), "Key");
      if (!is_whole_number(key)) continue;
      std::string name = xml.substr(open_end + 1, close - open_end - 1);
      if (name.starts_with("<![CDATA[") && name.ends_with("]]>")) name = name.substr(9, name.size() - 12);
      out.push_back({name, {0, std::strtod(key.c_str(), nullptr)}});
    }
  }
  return out;
}

std::vector<LabelValue> find_labels(const std::vector<std::string>& wanted, const std::vector<NamedSegment>& segments,
                                    int layers, const std::string& path) {
  std::vector<LabelValue> out;
  for (const std::string& label : wanted) {
    const LabelValue found =
        is_whole_number(label) ? find_number(label, segments, layers, path) : find_name(label, segments, path);
    if (found.layer >= layers) {
      throw InputError({path}, kLabelChoiceKey,
                       "'" + label + "' is in layer " + std::to_string(found.layer) + ", but the label map has " +
                           std::to_string(layers),
                       "the file is damaged; export it again");
    }
    out.push_back(found);
  }
  return out;
}

std::string words_of_labels(const std::vector<std::string>& labels) {
  std::string out;
  for (const std::string& label : labels) out += (out.empty() ? "" : ", ") + printable(label);
  return out;
}

}  // namespace reamsim::ct
