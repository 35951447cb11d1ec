// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "sim/scan/segment.h"

namespace reamsim::ct {

namespace {

/// Radius of the closing, in which bone without a label counts as part of the label. Wider notches, such as that
/// between acromion and glenoid, may lie between bones.
constexpr double kClosing_mm = 5;
/// Smaller parts are the partial volume at the surface, or noise.
constexpr double kWorthWarning_mm3 = 20;
/// A piece that is smaller than this part of the label is a speck.
constexpr double kSpeck = 0.002;

/// The box of the mask with a margin in which a closing acts.
IndexBox around(const Mask& mask, const Lattice& lattice) {
  Piece whole;
  lattice.for_each([&](const Vec3i& voxel, std::size_t at) {
    if (mask[at]) whole.add(voxel);
  });
  const Vec3i margin = (kClosing_mm * lattice.spacing_mm.cwiseInverse()).array().ceil().cast<int>() + 2;
  return box_around(whole.min, whole.max, margin, lattice);
}

/// Bone without a label in the closing of the label: the parts of it in which a box of three voxels fits, because
/// single layers are the partial volume at the surface.
class MissingBone {
 public:
  MissingBone(const LabelImages& labels, const AlignedImage& hu, const LabelMapSettings& map)
      : label_(positive_voxels(labels.selected)), box_(around(label_, hu.lattice)), part_(hu.lattice.part(box_)) {
    Mask closed = part_of(label_, hu.lattice, box_);
    holes_ = closed;
    fill_holes(holes_, part_);
    close_mask(closed, part_, kClosing_mm);
    missing_.assign(closed.size(), 0);
    part_.for_each([&](const Vec3i& voxel, std::size_t at) {
      const std::size_t in_image = hu.lattice.index(voxel + box_.start);
      const bool labelled = label_[in_image] || labels.other.value[in_image] > 0;
      const bool dense = static_cast<double>(hu.value[in_image]) >= map.refine_hu;
      missing_[at] = !labelled && dense && (closed[at] || holes_[at]);
    });
    const Vec3i one = Vec3i::Ones();
    const Mask thick = dilated(eroded(missing_, part_, one), part_, 2 * one);
    for (std::size_t at = 0; at < missing_.size(); ++at) missing_[at] = missing_[at] && thick[at];
    pieces_ = connected_pieces(missing_, part_);
  }

  /// Volume and place of the parts that are worth a warning.
  [[nodiscard]] std::string text() const {
    double all = 0;
    std::string places;
    for (const Piece& piece : pieces_.list) {
      const double mm3 = static_cast<double>(piece.voxels) * part_.voxel_mm3();
      if (mm3 < kWorthWarning_mm3) break;  // they are ordered by size
      all += mm3;
      constexpr std::size_t kMostText = 120;
      if (places.size() > kMostText) continue;
      const Vec3 middle = 0.5 * (part_.center_mm(piece.min) + part_.center_mm(piece.max));
      places += (places.empty() ? "" : ", ") + fmt::format("{:.0f} mm3 at {}", mm3, point_text(middle));
    }
    return all == 0 ? "" : fmt::format("{:.0f} mm3 of bone ({}, LPS)", all, places);
  }

  /// Adds them to the label, and the cavities that it encloses. Returns the volume, mm³.
  double fill(LabelImages& labels, const AlignedImage& hu) const {
    std::int64_t added = 0;
    part_.for_each([&](const Vec3i& voxel, std::size_t at) {
      const std::size_t in_image = hu.lattice.index(voxel + box_.start);
      const bool enclosed = holes_[at] && labels.other.value[in_image] == 0;
      if (label_[in_image] || !(enclosed || is_worth(at))) return;
      labels.selected.value[in_image] = 1;
      ++added;
    });
    return static_cast<double>(added) * part_.voxel_mm3();
  }

 private:
  [[nodiscard]] bool is_worth(std::size_t at) const {
    const std::uint32_t piece = pieces_.label[at];
    return piece != 0 && static_cast<double>(pieces_.list[piece - 1].voxels) * part_.voxel_mm3() >= kWorthWarning_mm3;
  }

  Mask label_;
  IndexBox box_;  ///< the part of the image around the label
  Lattice part_;
  Mask holes_;    ///< the label with its cavities
  Mask missing_;  ///< bone without a label
  Pieces pieces_;
};

/// Warns of a label that ends at the edge of the scan; the edges of a crop are the user's.
void warn_of_edge(const Mask& label, const Lattice& lattice, const CtSettings& settings, Diagnostics& report) {
  double area_mm2 = 0;
  lattice.for_each([&](const Vec3i& voxel, std::size_t at) {
    if (!label[at]) return;
    for (int axis = 0; axis < 3; ++axis) {
      const bool first = voxel[axis] == 0 && !settings.crop_min_mm;
      const bool last = voxel[axis] == lattice.dims[axis] - 1 && !settings.crop_max_mm;
      if (first || last) area_mm2 += lattice.voxel_mm3() / lattice.spacing_mm[axis];
    }
  });
  constexpr double kLeast_mm2 = 5;
  if (area_mm2 < kLeast_mm2) return;
  report.warn(
      settings.label_map->path +
      fmt::format(": the label ends at the edge of the scan, over {:.0f} mm2: the bone is cut off there", area_mm2));
}

void warn_of_pieces(const Mask& label, const Lattice& lattice, const std::string& path, Diagnostics& report) {
  const Pieces pieces = connected_pieces(label, lattice);
  if (pieces.list.size() < 2) return;
  double others = 0;
  for (std::size_t n = 1; n < pieces.list.size(); ++n) others += static_cast<double>(pieces.list[n].voxels);
  const double largest = static_cast<double>(pieces.list[0].voxels);
  const Vec3 middle = 0.5 * (lattice.center_mm(pieces.list[1].min) + lattice.center_mm(pieces.list[1].max));
  const std::string text =
      path + fmt::format(": the label has {} pieces: {:.0f} mm3, and {:.0f} mm3 beside it, the next at {}",
                         pieces.list.size(), largest * lattice.voxel_mm3(), others * lattice.voxel_mm3(),
                         point_text(middle));
  others > kSpeck* largest ? report.warn(text + " (LPS); all are bone") : report.note(text);
}

/// Least magnitude of a field, so that a voxel exactly at the threshold keeps its sign.
constexpr float kMinField_hu = 1;
/// Steps along a normal, as a fraction of the smallest spacing.
constexpr double kMarch = 0.25;

class Refinement {
 public:
  Refinement(const AlignedImage& field, const AlignedImage& other, const AlignedImage& hu, double threshold_hu,
             double reach_mm)
      : lattice_(hu.lattice),
        other_(other),
        hu_image_(hu),
        minus_field_(field),
        minus_hu_(hu),
        smooth_(field),
        mask_(positive_voxels(field)),
        threshold_hu_(threshold_hu),
        reach_mm_(reach_mm),
        march_mm_(kMarch * hu.lattice.spacing_mm.minCoeff()) {
    // Wide enough for a slope at any distance from the surface within the reach.
    gaussian_filter(smooth_, std::max(1.0, reach_mm / hu.lattice.spacing_mm.minCoeff()));
  }

  /// The refined mask.
  Mask run() {
    const Vec3i reach = (reach_mm_ * lattice_.spacing_mm.cwiseInverse()).array().ceil().cast<int>() + 1;
    const Mask near_bone = dilated(mask_, lattice_, reach);
    const Mask near_air = dilated(complement(mask_), lattice_, reach);
    Mask out = mask_;
    lattice_.for_each([&](const Vec3i& voxel, std::size_t at) {
      if (near_bone[at] && near_air[at]) out[at] = refined(voxel, at);
    });
    return out;
  }

  [[nodiscard]] const Mask& mask() const { return mask_; }

 private:
  [[nodiscard]] bool dense(const Vec3& point) const { return -minus_hu_(point) >= threshold_hu_; }
  [[nodiscard]] bool in_mask(const Vec3& point) const { return minus_field_(point) < 0; }
  [[nodiscard]] bool in_other(const Vec3& point) const {
    const Vec3i c = lattice_.voxel_of(point);
    return lattice_.contains(c) && !other_.value.empty() && other_.at(c) > 0;
  }

  [[nodiscard]] std::uint8_t refined(const Vec3i& c, std::size_t at) const {
    const bool is_dense = static_cast<double>(hu_image_.value[at]) >= threshold_hu_;
    const std::uint8_t as_it_is = mask_[at];
    if (is_dense == (as_it_is != 0)) return as_it_is;
    const Vec3 start = lattice_.center_mm(c);
    if (!as_it_is && in_other(start)) return as_it_is;
    const Vec3 out = -smooth_.gradient(c).stableNormalized();
    // All points up to the surface of the mask must be like the voxel; beyond it the HU must cross the threshold.
    const Vec3 to_surface = as_it_is ? out : Vec3(-out);
    const double to_surface_mm = distance_to_surface(start, to_surface, as_it_is != 0, is_dense);
    if (to_surface_mm < 0) return as_it_is;
    return crosses(start, -to_surface, is_dense, reach_mm_ - to_surface_mm) ? !as_it_is : as_it_is;
  }

  /// Distance to the surface of the mask in a direction, if all points on the way are as dense as the start; else −1.
  [[nodiscard]] double distance_to_surface(const Vec3& start, const Vec3& direction, bool is_bone,
                                           bool is_dense) const {
    for (double t = march_mm_; t <= reach_mm_; t += march_mm_) {
      const Vec3 point = start + t * direction;
      if (in_mask(point) != is_bone) return t;
      if (dense(point) != is_dense) return -1;
    }
    return -1;
  }

  [[nodiscard]] bool crosses(const Vec3& start, const Vec3& direction, bool is_dense, double most_mm) const {
    for (double t = march_mm_; t <= most_mm + march_mm_; t += march_mm_) {
      const Vec3 point = start + t * direction;
      if (is_dense && in_other(point)) return false;
      if (dense(point) != is_dense) return true;
    }
    return false;
  }

  const Lattice& lattice_;
  const AlignedImage& other_;
  const AlignedImage& hu_image_;
  NegatedField minus_field_;
  NegatedField minus_hu_;
  AlignedImage smooth_;
  Mask mask_;
  double threshold_hu_;
  double reach_mm_;
  double march_mm_;
};

}  // namespace

void check_label(LabelImages& labels, const AlignedImage& hu, const CtSettings& settings, Diagnostics& report) {
  const LabelMapSettings& map = *settings.label_map;
  const Mask label = positive_voxels(labels.selected);
  if (std::ranges::count(label, 1) == 0) return;  // segment_by_label() refuses it
  warn_of_edge(label, hu.lattice, settings, report);
  warn_of_pieces(label, hu.lattice, map.path, report);
  const MissingBone missing(labels, hu, map);
  if (map.fill) {
    const double added = missing.fill(labels, hu);
    report.note(fmt::format("label_map.fill: {:.0f} mm3 added", added));
    return;
  }
  const std::string text = missing.text();
  if (text.empty()) return;
  report.warn(
      map.path + ": " + text +
      fmt::format(" at or above {:.0f} HU, which the label surrounds, have no label. Correct the segmentation, or "
                  "set bone.ct.label_map.fill: true",
                  map.refine_hu));
}

std::vector<float> signed_field(const AlignedImage& hu, double threshold_hu, const Mask& bone) {
  std::vector<float> out(bone.size());
  for (std::size_t at = 0; at < bone.size(); ++at) {
    const float size = std::max(std::abs(hu.value[at] - static_cast<float>(threshold_hu)), kMinField_hu);
    out[at] = bone[at] ? size : -size;
  }
  return out;
}

void refine_to_isosurface(AlignedImage& field, const AlignedImage& other, const AlignedImage& hu, double threshold_hu,
                          double reach_mm, Diagnostics& report) {
  Refinement refinement(field, other, hu, threshold_hu, reach_mm);
  const Mask refined = refinement.run();
  const Mask& before = refinement.mask();
  std::int64_t added = 0;
  std::int64_t removed = 0;
  for (std::size_t at = 0; at < refined.size(); ++at) {
    added += refined[at] && !before[at];
    removed += before[at] && !refined[at];
  }
  field.value = signed_field(hu, threshold_hu, refined);
  report.note(fmt::format(
      "refined to the {:.0f} HU isosurface within {:.2g} mm: {} voxels added, {} removed, {:+.0f} mm3", threshold_hu,
      reach_mm, added, removed, static_cast<double>(added - removed) * hu.lattice.voxel_mm3()));
}

}  // namespace reamsim::ct
