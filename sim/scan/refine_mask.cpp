// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/segment.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

#include "sim/scan/aligned_image.h"
#include "sim/scan/scan.h"

namespace reamsim::ct {

namespace {

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
