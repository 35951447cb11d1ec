#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/bone/ct/scan.h"

namespace reamsim::ct {

/// The lattice of an image whose axes are those of LPS. Voxel (i,j,k) has its centre at origin_mm + spacing_mm·(i,j,k)
/// and stands at i + nx·(j + ny·k).
struct Lattice {
  Vec3i dims = Vec3i::Zero();
  Vec3 spacing_mm = Vec3::Ones();
  Vec3 origin_mm = Vec3::Zero();

  [[nodiscard]] std::int64_t size() const { return std::int64_t{1} * dims.x() * dims.y() * dims.z(); }
  [[nodiscard]] std::size_t index(const Vec3i& v) const {
    return static_cast<std::size_t>(v.x() + std::int64_t{dims.x()} * (v.y() + std::int64_t{dims.y()} * v.z()));
  }
  /// The voxel that stands at `index`.
  [[nodiscard]] Vec3i voxel_at(std::size_t index) const {
    const auto nx = static_cast<std::size_t>(dims.x()), ny = static_cast<std::size_t>(dims.y());
    return {static_cast<int>(index % nx), static_cast<int>(index / nx % ny), static_cast<int>(index / nx / ny)};
  }
  [[nodiscard]] Vec3 center_mm(const Vec3i& v) const { return origin_mm + spacing_mm.cwiseProduct(v.cast<double>()); }
  [[nodiscard]] double voxel_mm3() const { return spacing_mm.prod(); }
  /// The outer faces of the outermost voxels.
  [[nodiscard]] Aabb bounds_mm() const {
    return {origin_mm - 0.5 * spacing_mm,
            origin_mm + spacing_mm.cwiseProduct(dims.cast<double>() - Vec3::Constant(0.5))};
  }
  /// The voxel that holds a point; may lie outside.
  [[nodiscard]] Vec3i voxel_of(const Vec3& point_mm) const {
    return ((point_mm - origin_mm).cwiseQuotient(spacing_mm) + Vec3::Constant(0.5)).array().floor().cast<int>();
  }
  [[nodiscard]] bool contains(const Vec3i& c) const {
    return (c.array() >= 0).all() && (c.array() < dims.array()).all();
  }
};

struct AlignedImage {
  Lattice lattice;
  std::vector<float> value;
};

/// A crop box in LPS mm; an absent corner leaves that side open.
struct Crop {
  std::optional<Vec3> min_mm;
  std::optional<Vec3> max_mm;
};

/// Whether the image's axes are those of LPS but for order and sign: no voxel is off by more than 2 % of a voxel.
bool is_axis_aligned(const ScanGeometry& geometry);

/// The voxels to read: those with their centre in the crop box, and for an oblique image a voxel more all round,
/// because resampling interpolates. May be empty.
IndexBox voxels_in_crop(const ScanGeometry& geometry, const Crop& crop);

/// Brings an image to LPS axes. Axis-aligned ones are permuted and flipped, so that every value stays as it is; oblique
/// ones are interpolated trilinearly on a lattice as fine as the image, limited to the crop box, with `outside` where
/// the image has nothing. Throws std::length_error when spacing and axes ask for an absurdly large lattice.
AlignedImage align_to_lps(Scan scan, const Crop& crop, float outside);

}  // namespace reamsim::ct
