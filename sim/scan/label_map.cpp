// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/label_map.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "sim/base/error.h"
#include "sim/scan/scan.h"

namespace reamsim::ct {

namespace {

/// The map truncates the bone if it ends in contact with this area of bone.
constexpr double kCutOff_mm2 = 5;
constexpr std::size_t kMaxValues = 20;

/// The values of the wanted labels of one layer.
using Wanted = std::set<float>;

bool is_wanted(const Wanted& wanted, float value) {
  return value != 0 && wanted.contains(value);
}

/// The voxels of `labels` that can overlap the image; empty without an overlap.
IndexBox overlap_with(const ScanGeometry& labels, const ScanGeometry& image) {
  const Mat3 index_from_mm = labels.step_mm.inverse();
  const Aabb centers{Vec3::Zero(), image.dims.cast<double>() - Vec3::Ones()};
  Aabb indices = Aabb::none();
  for (int corner = 0; corner < 8; ++corner) {
    indices.extend(index_from_mm * (image.point_mm(centers.corner(corner)) - labels.origin_mm));
  }
  IndexBox out;
  for (int axis = 0; axis < 3; ++axis) {
    // One more voxel on either side, for the rounding of halfway points and for the border of the label.
    const double from = std::clamp(std::floor(indices.min[axis]) - 1, 0.0, static_cast<double>(labels.dims[axis]));
    const double to = std::clamp(std::ceil(indices.max[axis]) + 1, -1.0, labels.dims[axis] - 1.0);
    out.start[axis] = static_cast<int>(from);
    out.size[axis] = static_cast<int>(to - from) + 1;
  }
  return out;
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

/// Contact between the label and the border of the map, and the part of it with bone beyond the border.
struct CutOff {
  double contact_mm2 = 0;
  double bone_mm2 = 0;
};

/// Adds the contact on one face of the map.
void add_end(const ScanGeometry& labels, const Scan& part, const IndexBox& box, const Wanted& wanted, int axis,
             bool upper, const AlignedImage& hu, double threshold_hu, CutOff& cut) {
  const int level = upper ? labels.dims[axis] - 1 : 0;
  if (level < box.start[axis] || level >= box.start[axis] + box.size[axis]) return;
  const double area = labels.step_mm.col((axis + 1) % 3).cross(labels.step_mm.col((axis + 2) % 3)).norm();
  const Vec3i& size = part.geometry.dims;
  Vec3i first = Vec3i::Zero(), last = size - Vec3i::Ones();
  first[axis] = last[axis] = level - box.start[axis];
  for_each_voxel(first, last, [&](const Vec3i& c) {
    if (!is_wanted(wanted, part.value[index_in(size, c)])) return;
    Vec3 beyond = (c + box.start).cast<double>();
    beyond[axis] += upper ? 1 : -1;
    const Vec3i voxel = hu.lattice.voxel_of(labels.point_mm(beyond));
    if (!hu.lattice.contains(voxel)) return;
    cut.contact_mm2 += area;
    if (double{hu.at(voxel)} >= threshold_hu) cut.bone_mm2 += area;
  });
}

void report_cut_off(const CutOff& cut, const std::string& path, double threshold_hu, Diagnostics& report) {
  if (cut.contact_mm2 == 0) return;
  const std::string text =
      path + fmt::format(
                 ": the label touches the border of the map over {:.0f} mm2 inside the image, with "
                 "{:.0f} mm2 at or above {:.0f} HU beyond it",
                 cut.contact_mm2, cut.bone_mm2, threshold_hu);
  if (cut.bone_mm2 >= kCutOff_mm2) {
    report.warn(text + "; the map truncates the bone there");
  } else {
    report.note(text);
  }
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
      Wanted wanted;
      for (const LabelValue& label : labels) {
        if (label.layer == layer) wanted.insert(static_cast<float>(label.value));
      }
      if (!wanted.empty()) add_layer(box, layer, wanted);
    }
    if (inside_ == 0) throw no_overlap(map_.path, source_.geometry, image_, part_);
    if (wanted_voxels_ == 0) fail_without_label();
    report_cut_off(cut_, map_.path, settings_.threshold_hu, report_);
    const Crop crop{settings_.crop_min_mm, settings_.crop_max_mm};
    return {align_to_lps({part_, std::move(selected_)}, crop, 0), align_to_lps({part_, std::move(other_)}, crop, 0)};
  }

 private:
  void add_layer(const IndexBox& box, int layer, const Wanted& wanted) {
    const Scan labels = source_.read(box, layer);
    check_whole(labels, box);
    const auto nearest = nearest_in(source_.geometry, part_);
    float last = 0;
    for_each_voxel(part_.dims, [&](const Vec3i& voxel) {
      const Vec3i c = nearest(voxel) - box.start;
      if ((c.array() < 0).any() || (c.array() >= box.size.array()).any()) return;
      ++inside_;
      const float value = labels.value[index_in(box.size, c)];
      if (value != last && value != 0) seen_.insert(value);
      last = value;
      if (is_wanted(wanted, value)) {
        selected_[index_in(part_.dims, voxel)] = 1;
        ++wanted_voxels_;
      } else if (value != 0) {
        other_[index_in(part_.dims, voxel)] = 1;
      }
    });
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool upper : {false, true}) {
        add_end(source_.geometry, labels, box, wanted, axis, upper, hu_, settings_.threshold_hu, cut_);
      }
    }
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
        {map_.path}, "bone.ct.label_map.label", "no voxel in the crop has label " + words_of_labels(map_.label),
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
  CutOff cut_;
};

}  // namespace

LabelImages read_labels(const CtSettings& settings, const ScanGeometry& image, const IndexBox& box,
                        const AlignedImage& hu, Diagnostics& report) {
  return LabelReader(settings, image, box, hu, report).read();
}

}  // namespace reamsim::ct
