#include "sim/bone/ct/refine_mask.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

#include "sim/bone/ct/morphology.h"
#include "sim/bone/ct/resample.h"
#include "sim/bone/ct/words.h"

namespace reamsim::ct {

namespace {

/// Magnitude of the refined field for a voxel that is exactly at the threshold, so that its sign still counts.
constexpr float kLeastRefined_hu = 1;
/// Steps along a normal, as a fraction of the smallest spacing.
constexpr double kMarch = 0.25;

/// Every voxel with a marked one at most `reach` voxels away along each axis.
Mask spread_along_axes(const Mask& mask, const Lattice& lattice, const Vec3i& reach) {
  Mask from = mask;
  Mask to(mask.size());
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t stride = axis == 0 ? 1 : lattice.index(0, axis == 1 ? 1 : 0, axis == 2 ? 1 : 0);
    std::fill(to.begin(), to.end(), std::uint8_t{0});
    for (int k = 0; k < lattice.dims.z(); ++k) {
      for (int j = 0; j < lattice.dims.y(); ++j) {
        for (int i = 0; i < lattice.dims.x(); ++i) {
          const std::size_t at = lattice.index(i, j, k);
          if (!from[at]) continue;
          const int place = Vec3i(i, j, k)[axis];
          const int first = std::max(place - reach[axis], 0);
          const int last = std::min(place + reach[axis], lattice.dims[axis] - 1);
          for (int n = first; n <= last; ++n)
            to[at + stride * static_cast<std::size_t>(n) - stride * static_cast<std::size_t>(place)] = 1;
        }
      }
    }
    std::swap(from, to);
  }
  return from;
}

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
        threshold_hu_(threshold_hu),
        reach_mm_(reach_mm),
        march_mm_(kMarch * hu.lattice.spacing_mm.minCoeff()) {
    mask_.resize(field.value.size());
    std::ranges::transform(field.value, mask_.begin(), [](float value) { return value > 0 ? 1 : 0; });
    // Wide enough for a slope of it as far from the surface as the refinement reaches.
    gaussian_filter(smooth_, std::max(1.0, reach_mm / hu.lattice.spacing_mm.minCoeff()));
  }

  /// The refined mask.
  Mask run() {
    const Vec3i reach = (reach_mm_ * lattice_.spacing_mm.cwiseInverse()).array().ceil().cast<int>() + 1;
    Mask air(mask_.size());
    std::ranges::transform(mask_, air.begin(), [](std::uint8_t in) { return in ? 0 : 1; });
    const Mask near_bone = spread_along_axes(mask_, lattice_, reach);
    const Mask near_air = spread_along_axes(air, lattice_, reach);
    Mask out = mask_;
    for (int k = 0; k < lattice_.dims.z(); ++k) {
      for (int j = 0; j < lattice_.dims.y(); ++j) {
        for (int i = 0; i < lattice_.dims.x(); ++i) {
          const std::size_t at = lattice_.index(i, j, k);
          if (near_bone[at] && near_air[at]) out[at] = refined(Vec3i(i, j, k), at);
        }
      }
    }
    return out;
  }

  [[nodiscard]] const Mask& mask() const { return mask_; }

 private:
  [[nodiscard]] bool dense(const Vec3& point) const { return -minus_hu_(point) >= threshold_hu_; }
  [[nodiscard]] bool in_mask(const Vec3& point) const { return minus_field_(point) < 0; }
  [[nodiscard]] bool in_other(const Vec3& point) const {
    const Vec3i c = lattice_.voxel_of(point);
    return lattice_.contains(c) && !other_.value.empty() && other_.value[lattice_.index(c.x(), c.y(), c.z())] > 0;
  }

  /// Out of the mask at a voxel; zero where there is no telling.
  [[nodiscard]] Vec3 outward(const Vec3i& c) const {
    Vec3 slope;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3i low = c;
      Vec3i high = c;
      low[axis] = std::max(c[axis] - 1, 0);
      high[axis] = std::min(c[axis] + 1, lattice_.dims[axis] - 1);
      const double rise = double{smooth_.value[lattice_.index(high.x(), high.y(), high.z())]} -
                          double{smooth_.value[lattice_.index(low.x(), low.y(), low.z())]};
      const int steps = high[axis] - low[axis];
      slope[axis] = steps == 0 ? 0 : rise / (steps * lattice_.spacing_mm[axis]);
    }
    return -slope.stableNormalized();
  }

  [[nodiscard]] std::uint8_t refined(const Vec3i& c, std::size_t at) const {
    const bool is_dense = static_cast<double>(hu_image_.value[at]) >= threshold_hu_;
    const std::uint8_t as_it_is = mask_[at];
    if (is_dense == (as_it_is != 0)) return as_it_is;
    const Vec3 start = lattice_.center_mm(c.x(), c.y(), c.z());
    if (!as_it_is && in_other(start)) return as_it_is;
    const Vec3 out = outward(c);
    // From the voxel to the mask's surface all must be alike, and beyond the voxel the HU must cross the threshold.
    const Vec3 to_surface = as_it_is ? out : Vec3(-out);
    const double to_surface_mm = length_alike(start, to_surface, as_it_is != 0, is_dense);
    if (to_surface_mm < 0) return as_it_is;
    return crosses(start, -to_surface, is_dense, reach_mm_ - to_surface_mm) ? !as_it_is : as_it_is;
  }

  /// How far the mask's surface is in a direction, if all on the way is as dense as the start; else −1.
  [[nodiscard]] double length_alike(const Vec3& start, const Vec3& direction, bool is_bone, bool is_dense) const {
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

void refine_to_isosurface(AlignedImage& field, const AlignedImage& other, const AlignedImage& hu, double threshold_hu,
                          double reach_mm, Report& report) {
  Refinement refinement(field, other, hu, threshold_hu, reach_mm);
  const Mask refined = refinement.run();
  const Mask& before = refinement.mask();
  std::int64_t added = 0;
  std::int64_t removed = 0;
  for (std::size_t at = 0; at < refined.size(); ++at) {
    added += refined[at] && !before[at];
    removed += before[at] && !refined[at];
  }
  for (std::size_t at = 0; at < refined.size(); ++at) {
    const float size = std::max(std::abs(hu.value[at] - static_cast<float>(threshold_hu)), kLeastRefined_hu);
    field.value[at] = refined[at] ? size : -size;
  }
  report.note(fmt::format(
      "refined to the {:.0f} HU isosurface within {:.2g} mm: {} voxels added, {} removed, {:+.0f} mm3", threshold_hu,
      reach_mm, added, removed, static_cast<double>(added - removed) * hu.lattice.voxel_mm3()));
}

}  // namespace reamsim::ct
