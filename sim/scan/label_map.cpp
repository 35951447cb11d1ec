// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/segment.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <set>

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

/// The map truncates the bone if it ends in contact with this area of bone.
constexpr double kCutOff_mm2 = 5;
constexpr std::size_t kMaxValues = 20;

/// The voxels of `labels` that can overlap the image; empty without an overlap.
IndexBox overlap_with(const ScanGeometry& labels, const ScanGeometry& image) {
  const Mat3 index_from_mm = labels.step_mm.inverse();
  const Aabb centers{Vec3::Zero(), image.dims.cast<double>() - Vec3::Ones()};
  Aabb indices = Aabb::none();
  for (int corner = 0; corner < 8; ++corner) {
    indices.extend(index_from_mm * (image.point_mm(centers.corner(corner)) - labels.origin_mm));
  }
  // One more voxel on either side, for the rounding of halfway points and for the border of the label.
  const Eigen::Array3d dims = labels.dims.cast<double>();
  const Eigen::Array3d from = (indices.min.array().floor() - 1).max(0).min(dims);
  const Eigen::Array3d to = (indices.max.array().ceil() + 1).max(-1).min(dims - 1);
  return {from.cast<int>(), (to - from).cast<int>() + 1};
}

InputError no_overlap(const std::string& path, const ScanGeometry& labels, const ScanGeometry& image,
                      const ScanGeometry& part) {
  std::string found = "the label map does not overlap the image: it spans " + box_text(labels.bounds_mm()) +
                      ", the image spans " + box_text(image.bounds_mm());
  if (part.dims != image.dims) found += ", cropped to " + box_text(part.bounds_mm());
  return {{path},
          kLabelPathKey,
          found + " (LPS)",
          "expected a map of the same scan; check its origin and axes (RAS or LPS)"};
}

/// A function from a voxel of an image to the nearest voxel of a label map, in patient space. Halfway points, to within
/// a tolerance, belong to the voxel further along LPS, so that the result does not depend on the storage order.
auto nearest_in(const ScanGeometry& labels, const ScanGeometry& image) {
  const Mat3 index_from_mm = labels.step_mm.inverse();
  std::array<bool, 3> forward{};  // whether an axis of the map has the direction of LPS
  for (int axis = 0; axis < 3; ++axis) {
    int along = 0;
    labels.step_mm.col(axis).cwiseAbs().maxCoeff(&along);
    forward[static_cast<std::size_t>(axis)] = labels.step_mm(along, axis) > 0;
  }
  return [forward, step = Mat3(index_from_mm * image.step_mm),
          first = Vec3(index_from_mm * (image.origin_mm - labels.origin_mm)),
          last = Vec3(labels.dims.cast<double>() - Vec3::Ones())](const Vec3i& voxel) {
    constexpr double kTie_voxels = 0.01;
    const Vec3 at = first + step * voxel.cast<double>();
    Vec3i out;
    for (int axis = 0; axis < 3; ++axis) {
      const double nearest = forward[static_cast<std::size_t>(axis)] ? std::floor(at[axis] + 0.5 + kTie_voxels)
                                                                     : std::ceil(at[axis] - 0.5 - kTie_voxels);
      out[axis] = static_cast<int>(std::clamp(nearest, -1.0, last[axis] + 1));
    }
    return out;
  };
}

class LabelReader {
 public:
  LabelReader(const CtSettings& settings, const ScanGeometry& image, const IndexBox& box, const AlignedImage& hu,
              Diagnostics& report)
      : settings_(settings),
        map_(*settings.label_map),
        image_(image),
        part_(part_of(image, box)),
        hu_(hu),
        report_(report),
        source_(open_labels(map_.path, report)) {}

  LabelImages read() {
    const std::string layers = source_.layers > 1 ? std::to_string(source_.layers) + " layers, " : "";
    report_.note("label map " + map_.path + ": " + source_.description + ", " + shape_text(source_.geometry) + ", " +
                 layers + box_text(source_.geometry.bounds_mm()));
    const std::vector<LabelValue> labels = find_labels(map_.label, source_.segments, source_.layers, map_.path);
    const IndexBox box = overlap_with(source_.geometry, part_);
    if (box.empty()) throw no_overlap(map_.path, source_.geometry, image_, part_);
    const std::size_t voxels = static_cast<std::size_t>(part_.size());
    selected_.assign(voxels, 0);
    other_.assign(voxels, 0);
    for (int layer = 0; layer < source_.layers; ++layer) {
      std::set<float> wanted;
      for (const LabelValue& label : labels) {
        if (label.layer == layer) wanted.insert(static_cast<float>(label.value));
      }
      if (!wanted.empty()) add_layer(box, layer, wanted);
    }
    if (inside_ == 0) throw no_overlap(map_.path, source_.geometry, image_, part_);
    if (wanted_voxels_ == 0) fail_without_label();
    report_cut_off();
    return {align_to_lps({part_, std::move(selected_)}, settings_, 0),
            align_to_lps({part_, std::move(other_)}, settings_, 0)};
  }

 private:
  void add_layer(const IndexBox& box, int layer, const std::set<float>& wanted) {
    const Scan labels = source_.read(box, layer);
    check_whole(labels, box);
    const auto nearest = nearest_in(source_.geometry, part_);
    float last = 0;
    for_each_voxel(part_.dims, [&](const Vec3i& voxel) {
      const Vec3i c = nearest(voxel) - box.start;
      if (!contains_cell(box.size, c)) return;
      ++inside_;
      const float value = labels.value[index_in(box.size, c)];
      if (value != last && value != 0) seen_.insert(value);
      last = value;
      if (value == 0) return;
      if (wanted.contains(value)) {
        selected_[index_in(part_.dims, voxel)] = 1;
        ++wanted_voxels_;
      } else {
        other_[index_in(part_.dims, voxel)] = 1;
      }
    });
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool upper : {false, true}) {
        add_end(labels, box, wanted, axis, upper);
      }
    }
  }

  /// Adds the contact on one face of the map.
  void add_end(const Scan& part, const IndexBox& box, const std::set<float>& wanted, int axis, bool upper) {
    const ScanGeometry& labels = source_.geometry;
    const int level = upper ? labels.dims[axis] - 1 : 0;
    if (level < box.start[axis] || level >= box.start[axis] + box.size[axis]) return;
    const double area = labels.step_mm.col((axis + 1) % 3).cross(labels.step_mm.col((axis + 2) % 3)).norm();
    Vec3i first = Vec3i::Zero(), last = box.size - Vec3i::Ones();
    first[axis] = last[axis] = level - box.start[axis];
    for_each_voxel(first, last, [&](const Vec3i& c) {
      const float value = part.value[index_in(box.size, c)];
      if (value == 0 || !wanted.contains(value)) return;
      Vec3 beyond = (c + box.start).cast<double>();
      beyond[axis] += upper ? 1 : -1;
      const Vec3i voxel = hu_.lattice.voxel_of(labels.point_mm(beyond));
      if (!hu_.lattice.contains(voxel)) return;
      contact_mm2_ += area;
      if (double{hu_.at(voxel)} >= settings_.threshold_hu) bone_beyond_mm2_ += area;
    });
  }

  void report_cut_off() const {
    if (contact_mm2_ == 0) return;
    const std::string text = fmt::format(
        "{}: the label touches the border of the map over {:.0f} mm2 inside the image, with {:.0f} mm2 at or above "
        "{:.0f} HU beyond it",
        map_.path, contact_mm2_, bone_beyond_mm2_, settings_.threshold_hu);
    if (bone_beyond_mm2_ < kCutOff_mm2) return report_.note(text);
    report_.warn(text + "; the map truncates the bone there");
  }

  /// Labels are whole numbers, even in files of floating-point type.
  void check_whole(const Scan& labels, const IndexBox& box) const {
    if (source_.has_whole_numbers) return;
    for (std::size_t at = 0; at < labels.value.size(); ++at) {
      const float value = labels.value[at];
      if (std::isfinite(value) && value == std::floor(value)) continue;
      const Vec3i c = box.start + Lattice{.dims = box.size}.voxel_at(at);
      throw InputError({map_.path}, kLabelPathKey,
                       fmt::format("the value {:g} at voxel ({}, {}, {}) is not a label", static_cast<double>(value),
                                   c.x(), c.y(), c.z()),
                       "expected whole numbers; threshold a probability map and save it as integers");
    }
  }

  [[noreturn]] void fail_without_label() const {
    std::string values;
    std::size_t count = 0;
    for (const float value : seen_) {
      if (++count > kMaxValues) break;
      values += (values.empty() ? "" : ", ") + fmt::format("{:.0f}", static_cast<double>(value));
    }
    if (count > kMaxValues) values += ", ...";
    throw InputError(
        {map_.path}, kLabelChoiceKey, "no voxel in the crop has label " + words_of_labels(map_.label),
        values.empty() ? "the map has no label there; move the crop" : "the map holds " + values + " there");
  }

  const CtSettings& settings_;
  const LabelMapSettings& map_;
  const ScanGeometry& image_;
  ScanGeometry part_;
  const AlignedImage& hu_;
  Diagnostics& report_;
  ScanSource source_;
  std::vector<float> selected_;
  std::vector<float> other_;
  std::set<float> seen_;
  std::int64_t inside_ = 0;
  std::int64_t wanted_voxels_ = 0;
  double contact_mm2_ = 0;      ///< between the label and the border of the map
  double bone_beyond_mm2_ = 0;  ///< of it, with bone beyond the border
};

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

LabelImages read_labels(const CtSettings& settings, const ScanGeometry& image, const IndexBox& box,
                        const AlignedImage& hu, Diagnostics& report) {
  return LabelReader(settings, image, box, hu, report).read();
}

}  // namespace reamsim::ct
