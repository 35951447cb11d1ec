#include "sim/bone/ct/aligned_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace reamsim::ct {

namespace {

constexpr double kAlignedTolerance_voxels = 0.02;
/// The box round an oblique image holds at most 27 times its voxels unless spacing or axes are absurd.
constexpr double kMaxGrowth = 100;
/// A lattice cell that would hold less of the crop than this share is not added.
constexpr double kRounding_voxels = 1e-6;

/// For each image axis the LPS axis that it runs along most; the three differ, or the image is treated as oblique.
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
    // The outermost half voxel belongs to the image, and has the value of the outermost voxel.
    if (index[axis] < -0.5 || index[axis] > last + 0.5) return outside;
    const double inside = std::clamp(index[axis], 0.0, last);
    low[axis] = std::min(static_cast<int>(inside), std::max(dims[axis] - 2, 0));
    fraction[axis] = inside - low[axis];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3i bit(corner & 1, (corner >> 1) & 1, corner >> 2);
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) weight *= bit[axis] ? fraction[axis] : 1 - fraction[axis];
    if (weight == 0) continue;
    const Vec3i at = low + bit;
    sum += weight * scan.value[static_cast<std::size_t>(at.x() + std::int64_t{dims.x()} *
                                                                     (at.y() + std::int64_t{dims.y()} * at.z()))];
  }
  return sum;
}

AlignedImage permute(const Scan& scan) {
  const ScanGeometry& from = scan.geometry;
  const std::array<int, 3> lps_axis = dominant_axes(from.step_mm);
  AlignedImage out;
  std::array<std::int64_t, 3> stride{};  // in the source, for a step along each axis of LPS
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
  const Vec3i& dims = out.lattice.dims;
  out.value.resize(scan.value.size());
  auto* target = out.value.data();
  for (int k = 0; k < dims.z(); ++k) {
    for (int j = 0; j < dims.y(); ++j) {
      std::int64_t at = first + stride[1] * j + stride[2] * k;
      for (int i = 0; i < dims.x(); ++i, at += stride[0]) *target++ = scan.value[static_cast<std::size_t>(at)];
    }
  }
  return out;
}

/// As fine as the image along each axis of LPS: the spacing of the image axis that runs along it most.
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
  Aabb box = scan.geometry.bounds_mm();
  if (crop.min_mm) box.min = box.min.cwiseMax(*crop.min_mm);
  if (crop.max_mm) box.max = box.max.cwiseMin(*crop.max_mm);
  const Vec3 cells = (box.max - box.min).cwiseQuotient(lattice.spacing_mm);
  if (cells.prod() > kMaxGrowth * static_cast<double>(scan.value.size())) throw std::length_error("oblique lattice");
  lattice.dims = (cells.array() - kRounding_voxels).ceil().cast<int>().cwiseMax(1);
  lattice.origin_mm = box.min + 0.5 * lattice.spacing_mm;
  out.value.resize(static_cast<std::size_t>(lattice.size()));
  const Mat3 index_from_mm = scan.geometry.step_mm.inverse();
  for (int k = 0; k < lattice.dims.z(); ++k) {
    for (int j = 0; j < lattice.dims.y(); ++j) {
      for (int i = 0; i < lattice.dims.x(); ++i) {
        const Vec3 index = index_from_mm * (lattice.center_mm({{i, j, k}}) - scan.geometry.origin_mm);
        out.value[lattice.index({i, j, k})] = static_cast<float>(trilinear(scan, index, outside));
      }
    }
  }
  return out;
}

}  // namespace

Aabb ScanGeometry::bounds_mm() const {
  Aabb box{Vec3::Constant(std::numeric_limits<double>::infinity()),
           Vec3::Constant(-std::numeric_limits<double>::infinity())};
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 index;
    for (int axis = 0; axis < 3; ++axis) index[axis] = ((corner >> axis) & 1) ? dims[axis] - 0.5 : -0.5;
    box.min = box.min.cwiseMin(point_mm(index));
    box.max = box.max.cwiseMax(point_mm(index));
  }
  return box;
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
  // An open side of the box ends where the image ends.
  Aabb box = geometry.bounds_mm();
  if (crop.min_mm) box.min = box.min.cwiseMax(*crop.min_mm);
  if (crop.max_mm) box.max = box.max.cwiseMin(*crop.max_mm);
  if (box.empty()) return {};
  const Mat3 index_from_mm = geometry.step_mm.inverse();
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 point((corner & 1) ? box.max.x() : box.min.x(), (corner & 2) ? box.max.y() : box.min.y(),
                     (corner & 4) ? box.max.z() : box.min.z());
    const Vec3 index = index_from_mm * (point - geometry.origin_mm);
    low = low.cwiseMin(index);
    high = high.cwiseMax(index);
  }
  const double slack = aligned ? -kAlignedTolerance_voxels : -1;
  const Vec3i last_voxel = geometry.dims - Vec3i::Ones();
  IndexBox out;
  Vec3i last;
  for (int axis = 0; axis < 3; ++axis) {
    out.start[axis] = std::max(0, static_cast<int>(std::ceil(std::max(low[axis] + slack, -1.0))));
    last[axis] = std::min(last_voxel[axis],
                          static_cast<int>(std::floor(std::min<double>(high[axis] - slack, geometry.dims[axis]))));
  }
  out.size = (last - out.start + Vec3i::Ones()).cwiseMax(0);
  return out;
}

AlignedImage align_to_lps(Scan scan, const Crop& crop, float outside) {
  return is_axis_aligned(scan.geometry) ? permute(scan) : resample_oblique(scan, crop, outside);
}

}  // namespace reamsim::ct
