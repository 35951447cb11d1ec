// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scan/scan.h"

namespace reamsim::ct {

/// The lattice of an image with LPS axes. Voxel (i,j,k) has its centre at origin_mm + spacing_mm·(i,j,k) and the index
/// i + nx·(j + ny·k).
struct Lattice {
  Vec3i dims = Vec3i::Zero();
  Vec3 spacing_mm = Vec3::Ones();
  Vec3 origin_mm = Vec3::Zero();

  [[nodiscard]] std::int64_t size() const { return std::int64_t{1} * dims.x() * dims.y() * dims.z(); }
  [[nodiscard]] std::size_t index(const Vec3i& v) const { return index_in(dims, v); }
  [[nodiscard]] Vec3i voxel_at(std::size_t index) const { return cell_at(dims, index); }
  [[nodiscard]] Vec3 center_mm(const Vec3i& v) const { return origin_mm + spacing_mm.cwiseProduct(v.cast<double>()); }
  [[nodiscard]] double voxel_mm3() const { return spacing_mm.prod(); }
  /// The lattice of the voxels in `box`.
  [[nodiscard]] Lattice part(const IndexBox& box) const { return {box.size, spacing_mm, center_mm(box.start)}; }
  /// Outer faces of the outermost voxels.
  [[nodiscard]] Aabb bounds_mm() const {
    return {origin_mm - 0.5 * spacing_mm,
            origin_mm + spacing_mm.cwiseProduct(dims.cast<double>() - Vec3::Constant(0.5))};
  }
  /// The voxel that contains a point; it may lie outside.
  [[nodiscard]] Vec3i voxel_of(const Vec3& point_mm) const {
    return ((point_mm - origin_mm).cwiseQuotient(spacing_mm) + Vec3::Constant(0.5)).array().floor().cast<int>();
  }
  [[nodiscard]] bool contains(const Vec3i& c) const { return contains_cell(dims, c); }
  /// Calls visit(voxel, index) for all voxels, x fastest.
  template <class Visit>
  void for_each(const Visit& visit) const {
    std::size_t index = 0;
    for_each_voxel(dims, [&](const Vec3i& voxel) { visit(voxel, index++); });
  }
};

struct AlignedImage {
  Lattice lattice;
  std::vector<float> value;

  [[nodiscard]] float at(const Vec3i& voxel) const { return value[lattice.index(voxel)]; }
  /// Central differences, one-sided at the border, per mm.
  [[nodiscard]] Vec3 gradient(const Vec3i& voxel) const;
};

/// Position along an axis in image voxels: 0 is the lower face of voxel 0, 1 its upper face.
inline double faces_from_mm(const Lattice& image, double mm, int axis) {
  return (mm - image.origin_mm[axis]) / image.spacing_mm[axis] + 0.5;
}

/// Tolerance of whole numbers of voxels; coordinates of real scans are rounded.
inline constexpr double kRounding = 1e-6;

/// The trilinear interpolation at an index between the voxels of an image. Beyond the image the value of its border
/// holds.
double interpolated(const std::vector<float>& value, const Vec3i& dims, const Vec3& index);

/// Whether the axes of the image are LPS axes in any order and direction, to within 2 % of a voxel at every voxel.
bool is_axis_aligned(const ScanGeometry& geometry);

/// The voxels to read: those with their centre in the crop box of the settings; for an oblique image one more on every
/// side, for interpolation. May be empty.
IndexBox voxels_in_crop(const ScanGeometry& geometry, const CtSettings& settings);

/// How an oblique image is interpolated. Linear interpolation blurs edges, which moves a surface above the middle of
/// their values inwards; cubic interpolation, limited to the eight values around, keeps them.
enum class Interpolation { linear, cubic };

/// Brings an image to LPS axes. An axis-aligned image is permuted and flipped without changing values. An oblique image
/// is interpolated on a lattice of the same spacing within the crop box, with `outside` beyond the image. Throws
/// std::length_error for an absurdly large lattice.
AlignedImage align_to_lps(const Scan& scan, const CtSettings& settings, float outside,
                          Interpolation by = Interpolation::linear);

/// The weights of image values for one voxel along one axis: weight[n] for value first + n. Their sum is 1. They
/// average over the voxel if it is at least as large as the spacing, otherwise they interpolate linearly at its centre
/// (paper §3.2). Beyond the image the value of its border holds.
struct AxisWeights {
  int first = 0;
  std::vector<double> weight;
};

/// Resamples an image to a grid. It works by slices (constant k), so that a fine grid of a large bone needs no second
/// large array. It is separable: each axis averages or interpolates by itself.
class SliceResampler {
 public:
  SliceResampler(const AlignedImage& image, const VoxelGrid& grid);

  /// Values of slice k; value (i,j) has the index i + nx·j.
  [[nodiscard]] std::vector<double> slice(int k) const;
  /// The value of one voxel.
  [[nodiscard]] double at(const Vec3i& voxel) const;

 private:
  const AlignedImage& image_;
  std::vector<AxisWeights> weights_[3];
};

/// The negative of an image, interpolated trilinearly: a field for fraction_inside(), negative where the image is above
/// 0. Beyond the image the value of its border holds.
class NegatedField {
 public:
  explicit NegatedField(const AlignedImage& image);

  double operator()(const Vec3& mm) const { return at(place(0, mm.x()), place(1, mm.y()), place(2, mm.z())); }
  /// For field_stencil(): a coordinate that points share is placed once.
  friend SevenPoints seven_points(const NegatedField& field, const Vec3& mm, double step) {
    const Place x = field.place(0, mm.x()), y = field.place(1, mm.y()), z = field.place(2, mm.z());
    const auto on_x = [&](double offset) { return field.at(field.place(0, mm.x() + offset), y, z); };
    const auto on_y = [&](double offset) { return field.at(x, field.place(1, mm.y() + offset), z); };
    const auto on_z = [&](double offset) { return field.at(x, y, field.place(2, mm.z() + offset)); };
    return {field.at(x, y, z), {on_x(-step), on_y(-step), on_z(-step)}, {on_x(step), on_y(step), on_z(step)}};
  }

 private:
  /// A position between two neighbouring values along one axis.
  struct Place {
    std::size_t at = 0;   ///< offset of the lower value
    double fraction = 0;  ///< weight of the upper value
  };

  [[nodiscard]] double at(Place x, Place y, Place z) const {
    const float* corner = values_ + x.at + y.at + z.at;
    const auto along_x = [&](std::size_t at) {
      return (1 - x.fraction) * double{corner[at]} + x.fraction * double{corner[at + step_[0]]};
    };
    const auto along_y = [&](std::size_t at) {
      return (1 - y.fraction) * along_x(at) + y.fraction * along_x(at + step_[1]);
    };
    return -((1 - z.fraction) * along_y(0) + z.fraction * along_y(step_[2]));
  }
  [[nodiscard]] Place place(int axis, double mm) const {
    const double index = std::min(std::max((mm - origin_mm_[axis]) / spacing_mm_[axis], 0.0), last_[axis]);
    const int low = std::min(static_cast<int>(index), last_low_[axis]);
    return {stride_[static_cast<std::size_t>(axis)] * static_cast<std::size_t>(low), index - low};
  }

  const float* values_;
  Vec3 origin_mm_;
  Vec3 spacing_mm_;
  Vec3 last_;       ///< index of the last value along each axis
  Vec3i last_low_;  ///< index of the last value that has a successor
  std::array<std::size_t, 3> stride_{};
  std::array<std::size_t, 3> step_{};  ///< to the upper value; 0 along axes with one voxel
};

}  // namespace reamsim::ct
