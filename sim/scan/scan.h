// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <fmt/core.h>
#include <cstdint>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/isolation/child_result.h"
#include "sim/scenario/scenario.h"

namespace reamsim::ct {

/// The geometry of an image. Voxel (i,j,k) has its centre at origin_mm + step_mm·(i,j,k)ᵀ in LPS mm. The columns of
/// `step_mm` may be oblique, and not perpendicular to one another (a tilted gantry).
struct ScanGeometry {
  Vec3i dims = Vec3i::Zero();
  Mat3 step_mm = Mat3::Identity();
  Vec3 origin_mm = Vec3::Zero();

  [[nodiscard]] std::int64_t size() const { return std::int64_t{1} * dims.x() * dims.y() * dims.z(); }
  [[nodiscard]] Vec3 spacing_mm() const { return step_mm.colwise().norm().transpose(); }
  [[nodiscard]] Vec3 point_mm(const Vec3& index) const { return origin_mm + step_mm * index; }
  /// Bounding box along the LPS axes of all voxels (their outer faces).
  [[nodiscard]] Aabb bounds_mm() const;
  /// Whether voxels have a volume, and edges of a plausible length.
  [[nodiscard]] bool is_valid() const;

  static auto fields(auto& self) { return std::tie(self.dims, self.step_mm, self.origin_mm); }
};

/// A box of voxels: from `start`, `size` voxels along each axis.
struct IndexBox {
  Vec3i start = Vec3i::Zero();
  Vec3i size = Vec3i::Zero();

  [[nodiscard]] bool empty() const { return (size.array() <= 0).any(); }
  [[nodiscard]] std::int64_t voxels() const { return std::int64_t{1} * size.x() * size.y() * size.z(); }

  static auto fields(auto& self) { return std::tie(self.start, self.size); }
};

/// The geometry of the voxels in `box`.
ScanGeometry part_of(const ScanGeometry& geometry, const IndexBox& box);

/// Part of an image in memory, in the order of index_in().
struct Scan {
  ScanGeometry geometry;
  std::vector<float> value;
};

/// A value of a label map and its layer.
struct LabelValue {
  int layer = 0;
  double value = 1;
};

struct NamedSegment {
  std::string name;
  LabelValue label;

  static auto fields(auto& self) { return std::tie(self.name, self.label); }
};

/// A scan or label map whose header has been read. Its voxels are read on demand.
struct ScanSource {
  ScanGeometry geometry;
  std::string description;  ///< format and pixel type for the report: "NRRD, int16"
  double kvp = 0;           ///< tube voltage, kV; 0: the file does not say
  int layers = 1;           ///< of a label map: the values that a voxel has
  bool has_whole_numbers = true;
  std::vector<NamedSegment> segments;  ///< the labels that the file names
  /// The values of a layer in `box`, which lies inside the image. Throws InputError: truncated, damaged.
  std::function<Scan(const IndexBox& box, int layer)> read;
};

/// The scenario keys of the files, for messages.
inline constexpr const char* kScanKey = "bone.ct.path";
inline constexpr const char* kLabelPathKey = "bone.ct.label_map.path";

/// Opens `settings.path`: a DICOM folder, a multi-frame DICOM file, NRRD, NIfTI or MetaImage. Throws InputError: no
/// such file, none of these formats, not a volume of single numbers, larger than the memory, or shorter than its header
/// claims; for DICOM see choose_series() and stack_slices().
ScanSource open_scan(const CtSettings& settings, Diagnostics& report);

/// Opens an NRRD, NIfTI, MetaImage or DICOM SEG. Throws InputError as open_scan() does.
ScanSource open_labels(const std::string& path, Diagnostics& report);

/// Throws InputError when `voxels` voxels of `bytes_per_voxel` are more than half of this machine's memory.
void check_fits_in_memory(double voxels, double bytes_per_voxel, const ForeignFile& file);

/// "26x30x24 voxels of 1x1x1.25 mm".
inline std::string shape_text(const ScanGeometry& g) {
  const Vec3 spacing = g.spacing_mm();
  return fmt::format("{}x{}x{} voxels of {:.4g}x{:.4g}x{:.4g} mm", g.dims.x(), g.dims.y(), g.dims.z(), spacing.x(),
                     spacing.y(), spacing.z());
}

inline std::string box_text(const Aabb& box) {
  return point_text(box.min) + " to " + point_text(box.max) + " mm";
}

}  // namespace reamsim::ct
