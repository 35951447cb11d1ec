// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/bone/voxmap/voxel_grid.h"
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
  [[nodiscard]] Vec3i voxel_at(std::size_t index) const {
    const auto nx = static_cast<std::size_t>(dims.x()), ny = static_cast<std::size_t>(dims.y());
    return {static_cast<int>(index % nx), static_cast<int>(index / nx % ny), static_cast<int>(index / nx / ny)};
  }
  [[nodiscard]] Vec3 center_mm(const Vec3i& v) const { return origin_mm + spacing_mm.cwiseProduct(v.cast<double>()); }
  [[nodiscard]] double voxel_mm3() const { return spacing_mm.prod(); }
  /// Outer faces of the outermost voxels.
  [[nodiscard]] Aabb bounds_mm() const {
    return {origin_mm - 0.5 * spacing_mm,
            origin_mm + spacing_mm.cwiseProduct(dims.cast<double>() - Vec3::Constant(0.5))};
  }
  /// The voxel that contains a point; it may lie outside.
  [[nodiscard]] Vec3i voxel_of(const Vec3& point_mm) const {
    return ((point_mm - origin_mm).cwiseQuotient(spacing_mm) + Vec3::Constant(0.5)).array().floor().cast<int>();
  }
  [[nodiscard]] bool contains(const Vec3i& c) const {
    return (c.array() >= 0).all() && (c.array() < dims.array()).all();
  }
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

/// A crop box in LPS mm; a missing corner leaves that side open.
struct Crop {
  std::optional<Vec3> min_mm;
  std::optional<Vec3> max_mm;
};

/// Whether the axes of the image are LPS axes in any order and direction, to within 2 % of a voxel at every voxel.
bool is_axis_aligned(const ScanGeometry& geometry);

/// The voxels to read: those with their centre in the crop box; for an oblique image one more on every side, for
/// interpolation. May be empty.
IndexBox voxels_in_crop(const ScanGeometry& geometry, const Crop& crop);

/// Brings an image to LPS axes. An axis-aligned image is permuted and flipped without changing values. An oblique image
/// is interpolated trilinearly on a lattice of the same spacing within the crop box, with `outside` beyond the image.
/// Throws std::length_error for an absurdly large lattice.
AlignedImage align_to_lps(const Scan& scan, const Crop& crop, float outside);

}  // namespace reamsim::ct
