// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/aligned_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace reamsim::ct {

namespace {

constexpr double kAlignedTolerance_voxels = 0.02;
/// The box around an oblique image has at most 27 times its voxels unless spacing or axes are absurd.
constexpr double kMaxGrowth = 100;
/// A voxel of which a smaller fraction lies in the crop is not added.
constexpr double kRounding_voxels = 1e-6;

/// For each image axis the closest LPS axis. If two are equal, the image is oblique.
std::array<int, 3> dominant_axes(const Mat3& step_mm) {
  std::array<int, 3> lps_axis{};
  for (int column = 0; column < 3; ++column) step_mm.col(column).cwiseAbs().maxCoeff(&lps_axis[column]);
  return lps_axis;
}

bool is_permutation(const std::array<int, 3>& axes) {
  return axes[0] != axes[1] && axes[1] != axes[2] && axes[0] != axes[2];
}

double trilinear(const Scan& scan, const Vec3& index, float outside) {
  const Vec3i& dims = scan.geometry.dims;
  Vec3i low;
  Vec3 fraction;
  for (int axis = 0; axis < 3; ++axis) {
    const double last = dims[axis] - 1;
    // The outermost half voxel belongs to the image and has the value of the outermost voxel.
    if (index[axis] < -0.5 || index[axis] > last + 0.5) return outside;
    const double inside = std::clamp(index[axis], 0.0, last);
    low[axis] = std::min(static_cast<int>(inside), std::max(dims[axis] - 2, 0));
    fraction[axis] = inside - low[axis];
  }
  double sum = 0;
  for_each_trilinear_weight(
      fraction, [&](const Vec3i& step, double weight) { sum += weight * scan.value[index_in(dims, low + step)]; });
  return sum;
}

Aabb cropped(Aabb box, const Crop& crop) {
  if (crop.min_mm) box.min = box.min.cwiseMax(*crop.min_mm);
  if (crop.max_mm) box.max = box.max.cwiseMin(*crop.max_mm);
  return box;
}

AlignedImage permute(const Scan& scan) {
  const ScanGeometry& from = scan.geometry;
  const std::array<int, 3> lps_axis = dominant_axes(from.step_mm);
  AlignedImage out;
  std::array<std::int64_t, 3> stride{};  // in the source, along each LPS axis
  const std::array<std::int64_t, 3> source_stride{1, from.dims.x(), std::int64_t{from.dims.x()} * from.dims.y()};
  std::int64_t first = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int to = lps_axis[axis];
    const double step = from.step_mm(to, axis);
    out.lattice.dims[to] = from.dims[axis];
    out.lattice.spacing_mm[to] = std::abs(step);
    out.lattice.origin_mm[to] = from.origin_mm[to] + (step < 0 ? step * (from.dims[axis] - 1) : 0);
    stride[to] = step < 0 ? -source_stride[axis] : source_stride[axis];
    if (step < 0) first += source_stride[axis] * (from.dims[axis] - 1);
  }
  out.value.resize(scan.value.size());
  out.lattice.for_each([&](const Vec3i& v, std::size_t at) {
    const std::int64_t source = first + stride[0] * v.x() + stride[1] * v.y() + stride[2] * v.z();
    out.value[at] = scan.value[static_cast<std::size_t>(source)];
  });
  return out;
}

/// The spacing along each LPS axis is that of the closest image axis.
Vec3 lattice_spacing(const ScanGeometry& geometry) {
  const std::array<int, 3> lps_axis = dominant_axes(geometry.step_mm);
  const Vec3 spacing = geometry.spacing_mm();
  if (!is_permutation(lps_axis)) return Vec3::Constant(spacing.minCoeff());
  Vec3 out;
  for (int axis = 0; axis < 3; ++axis) out[lps_axis[axis]] = spacing[axis];
  return out;
}

AlignedImage resample_oblique(const Scan& scan, const Crop& crop, float outside) {
  AlignedImage out;
  Lattice& lattice = out.lattice;
  lattice.spacing_mm = lattice_spacing(scan.geometry);
  const Aabb box = cropped(scan.geometry.bounds_mm(), crop);
  const Vec3 cells = (box.max - box.min).cwiseQuotient(lattice.spacing_mm);
  if (cells.prod() > kMaxGrowth * static_cast<double>(scan.value.size())) throw std::length_error("oblique lattice");
  lattice.dims = (cells.array() - kRounding_voxels).ceil().cast<int>().cwiseMax(1);
  lattice.origin_mm = box.min + 0.5 * lattice.spacing_mm;
  out.value.resize(static_cast<std::size_t>(lattice.size()));
  const Mat3 index_from_mm = scan.geometry.step_mm.inverse();
  lattice.for_each([&](const Vec3i& voxel, std::size_t at) {
    const Vec3 index = index_from_mm * (lattice.center_mm(voxel) - scan.geometry.origin_mm);
    out.value[at] = static_cast<float>(trilinear(scan, index, outside));
  });
  return out;
}

}  // namespace

Aabb ScanGeometry::bounds_mm() const {
  const Aabb faces{Vec3::Constant(-0.5), dims.cast<double>() - Vec3::Constant(0.5)};
  Aabb box = Aabb::none();
  for (int corner = 0; corner < 8; ++corner) box.extend(point_mm(faces.corner(corner)));
  return box;
}

Vec3 AlignedImage::gradient(const Vec3i& voxel) const {
  Vec3 out = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    Vec3i before = voxel, after = voxel;
    before[axis] = std::max(voxel[axis] - 1, 0);
    after[axis] = std::min(voxel[axis] + 1, lattice.dims[axis] - 1);
    if (before[axis] == after[axis]) continue;
    const double difference = double{at(after)} - double{at(before)};
    out[axis] = difference / ((after[axis] - before[axis]) * lattice.spacing_mm[axis]);
  }
  return out;
}

ScanGeometry part_of(const ScanGeometry& geometry, const IndexBox& box) {
  return {box.size, geometry.step_mm, geometry.point_mm(box.start.cast<double>())};
}

bool is_axis_aligned(const ScanGeometry& geometry) {
  const std::array<int, 3> lps_axis = dominant_axes(geometry.step_mm);
  if (!is_permutation(lps_axis)) return false;
  const double smallest = geometry.spacing_mm().minCoeff();
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 drift = geometry.step_mm.col(axis) * (geometry.dims[axis] - 1);
    drift[lps_axis[axis]] = 0;
    if (drift.cwiseAbs().maxCoeff() > kAlignedTolerance_voxels * smallest) return false;
  }
  return true;
}

IndexBox voxels_in_crop(const ScanGeometry& geometry, const Crop& crop) {
  const bool aligned = is_axis_aligned(geometry);
  const Aabb box = cropped(geometry.bounds_mm(), crop);
  if (box.empty()) return {};
  const Mat3 index_from_mm = geometry.step_mm.inverse();
  Aabb indices = Aabb::none();
  for (int corner = 0; corner < 8; ++corner) {
    indices.extend(index_from_mm * (box.corner(corner) - geometry.origin_mm));
  }
  const double slack = aligned ? -kAlignedTolerance_voxels : -1;
  const Vec3i last_voxel = geometry.dims - Vec3i::Ones();
  IndexBox out;
  Vec3i last;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::max(indices.min[axis] + slack, -1.0);
    const double high = std::min<double>(indices.max[axis] - slack, geometry.dims[axis]);
    out.start[axis] = std::max(0, static_cast<int>(std::ceil(low)));
    last[axis] = std::min(last_voxel[axis], static_cast<int>(std::floor(high)));
  }
  out.size = (last - out.start + Vec3i::Ones()).cwiseMax(0);
  return out;
}

AlignedImage align_to_lps(const Scan& scan, const Crop& crop, float outside) {
  return is_axis_aligned(scan.geometry) ? permute(scan) : resample_oblique(scan, crop, outside);
}

}  // namespace reamsim::ct
