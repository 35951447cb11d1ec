// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <fmt/core.h>
#include <cstdint>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"

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

/// The index of a voxel in an array of `dims` voxels: i + nx·(j + ny·k).
inline std::size_t index_in(const Vec3i& dims, const Vec3i& v) {
  return static_cast<std::size_t>(v.x() + std::int64_t{dims.x()} * (v.y() + std::int64_t{dims.y()} * v.z()));
}

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

/// An image file whose header has been read. Its voxels are read on demand.
class ScanSource {
 public:
  virtual ~ScanSource() = default;
  [[nodiscard]] virtual const ScanGeometry& geometry() const = 0;
  /// Format and pixel type for the report: "NRRD, int16".
  [[nodiscard]] virtual std::string description() const = 0;
  /// Tube voltage, kV; 0: the file does not say.
  [[nodiscard]] virtual double kvp() const { return 0; }
  /// The values of the voxels in `box`, which lies inside the image. Throws InputError: truncated, damaged.
  [[nodiscard]] virtual Scan read(const IndexBox& box) const = 0;
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

/// A label map file. Its voxels may have several values, the layers.
class LabelSource : public ScanSource {
 public:
  [[nodiscard]] virtual int layers() const = 0;
  [[nodiscard]] virtual bool has_whole_numbers() const = 0;
  /// As read(), for one layer.
  [[nodiscard]] virtual Scan read_layer(const IndexBox& box, int layer) const = 0;
  /// The labels that the file names.
  [[nodiscard]] virtual const std::vector<NamedSegment>& segments() const = 0;
};

/// Selects a DICOM series of a folder.
struct DicomChoice {
  std::string series;  ///< bone.ct.series; empty: the largest
  bool any_modality = false;
  bool resample = false;  ///< slices that are not evenly spaced are interpolated
};

/// Opens a DICOM folder, a multi-frame DICOM file, NRRD, NIfTI or MetaImage. `key` is the scenario key of `path`, for
/// messages. Throws InputError: no such file, none of these formats, not a volume of single numbers, larger than the
/// memory, or shorter than its header claims; for DICOM see choose_series() and stack_slices().
std::unique_ptr<ScanSource> open_scan(const std::string& path, const std::string& key, const DicomChoice& choice,
                                      Diagnostics& report);

/// Opens an NRRD, NIfTI, MetaImage or DICOM SEG. Throws InputError as open_scan() does.
std::unique_ptr<LabelSource> open_labels(const std::string& path, const std::string& key, Diagnostics& report);

/// Throws InputError when `voxels` voxels of `bytes_per_voxel` are more than half of this machine's memory.
void check_fits_in_memory(double voxels, double bytes_per_voxel, const std::string& path, const std::string& key);

inline std::string point_text(const Vec3& p) {
  return fmt::format("({:.1f}, {:.1f}, {:.1f})", p.x(), p.y(), p.z());
}

inline std::string box_text(const Aabb& box) {
  return point_text(box.min) + " to " + point_text(box.max) + " mm";
}

}  // namespace reamsim::ct
