// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/aligned_image.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/base/parallel.h"

namespace reamsim::ct {

namespace {

constexpr double kAlignedTolerance_voxels = 0.02;
/// The box around an oblique image has at most 27 times its voxels unless spacing or axes are absurd.
constexpr double kMaxGrowth = 100;

/// For each image axis the closest LPS axis; nullopt where two are equal: the image is oblique.
std::optional<std::array<int, 3>> dominant_axes(const Mat3& step_mm) {
  std::array<int, 3> axes{};
  for (int column = 0; column < 3; ++column) step_mm.col(column).cwiseAbs().maxCoeff(&axes[column]);
  const bool all = axes[0] != axes[1] && axes[1] != axes[2] && axes[0] != axes[2];
  return all ? std::optional(axes) : std::nullopt;
}

Aabb cropped(Aabb box, const CtSettings& settings) {
  if (settings.crop_min_mm) box.min = box.min.cwiseMax(*settings.crop_min_mm);
  if (settings.crop_max_mm) box.max = box.max.cwiseMin(*settings.crop_max_mm);
  return box;
}

AlignedImage permute(const Scan& scan) {
  const ScanGeometry& from = scan.geometry;
  const std::array<int, 3> lps_axis = *dominant_axes(from.step_mm);
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
  const auto lps_axis = dominant_axes(geometry.step_mm);
  const Vec3 spacing = geometry.spacing_mm();
  if (!lps_axis) return Vec3::Constant(spacing.minCoeff());
  Vec3 out;
  for (int axis = 0; axis < 3; ++axis) out[(*lps_axis)[axis]] = spacing[axis];
  return out;
}

/// The weights of Keys' cubic convolution (1981, IEEE Transactions on Acoustics, Speech, and Signal Processing 29,
/// 1153–1160) for the values at −1, 0, 1, 2, with the slope −0.75 at 1, which keeps edges better than −0.5.
std::array<double, 4> cubic_weights(double t) {
  constexpr double kSlope = -0.75;
  const double u = 1 - t;
  const auto inner = [](double x) { return ((kSlope + 2) * x - (kSlope + 3)) * x * x + 1; };
  return {kSlope * t * u * u, inner(t), inner(u), kSlope * u * t * t};
}

/// Cubic interpolation at an index, limited to the values of the eight voxels around it.
double interpolated_cubic(const std::vector<float>& value, const Vec3i& dims, const Vec3& index) {
  const Vec3 inside = index.cwiseMax(0).cwiseMin((dims - Vec3i::Ones()).cast<double>());
  const Vec3i low = inside.cast<int>();
  std::array<std::array<double, 4>, 3> weights{};
  for (int axis = 0; axis < 3; ++axis) weights[axis] = cubic_weights(inside[axis] - low[axis]);
  double sum = 0, least = std::numeric_limits<double>::infinity(), most = -least;
  for_each_voxel(Vec3i::Zero(), Vec3i::Constant(3), [&](const Vec3i& step) {
    const Vec3i at = (low + step - Vec3i::Ones()).cwiseMax(0).cwiseMin(dims - Vec3i::Ones());
    const auto v = static_cast<double>(value[index_in(dims, at)]);
    double weight = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) weight *= weights[axis][static_cast<std::size_t>(step[axis])];
    sum += weight * v;
    if ((step.array() < 1).any() || (step.array() > 2).any()) return;
    least = std::min(least, v);
    most = std::max(most, v);
  });
  return std::clamp(sum, least, most);
}

AlignedImage resample_oblique(const Scan& scan, const CtSettings& settings, float outside, Interpolation by) {
  AlignedImage out;
  Lattice& lattice = out.lattice;
  lattice.spacing_mm = lattice_spacing(scan.geometry);
  const Aabb box = cropped(scan.geometry.bounds_mm(), settings);
  const Vec3 cells = (box.max - box.min).cwiseQuotient(lattice.spacing_mm);
  if (cells.prod() > kMaxGrowth * static_cast<double>(scan.value.size())) throw std::length_error("oblique lattice");
  lattice.dims = (cells.array() - kRounding).ceil().cast<int>().cwiseMax(1);
  lattice.origin_mm = box.min + 0.5 * lattice.spacing_mm;
  out.value.resize(static_cast<std::size_t>(lattice.size()));
  const Mat3 index_from_mm = scan.geometry.step_mm.inverse();
  const Vec3 last = (scan.geometry.dims - Vec3i::Ones()).cast<double>();
  const auto& value_at = by == Interpolation::cubic ? interpolated_cubic : interpolated;
  parallel_items(static_cast<std::size_t>(lattice.dims.z()), [&](std::size_t slice) {
    const int k = static_cast<int>(slice);
    for_each_voxel({0, 0, k}, {lattice.dims.x() - 1, lattice.dims.y() - 1, k}, [&](const Vec3i& voxel) {
      const Vec3 index = index_from_mm * (lattice.center_mm(voxel) - scan.geometry.origin_mm);
      // The outermost half voxel belongs to the image and has the value of the outermost voxel.
      const bool beyond = (index.array() < -0.5).any() || (index.array() > last.array() + 0.5).any();
      out.value[lattice.index(voxel)] =
          beyond ? outside : static_cast<float>(value_at(scan.value, scan.geometry.dims, index));
    });
  });
  return out;
}

AxisWeights average(double from, double to, int count) {
  const double low = std::clamp<double>(from, 0, count - 1);
  const double high = std::clamp<double>(to, low, count);
  AxisWeights out;
  out.first = std::min(static_cast<int>(std::floor(low + kRounding)), count - 1);
  const int last = std::clamp(static_cast<int>(std::ceil(high - kRounding)) - 1, out.first, count - 1);
  double sum = 0;
  for (int n = out.first; n <= last; ++n) {
    const double overlap = std::max(0.0, std::min<double>(high, n + 1) - std::max<double>(low, n));
    out.weight.push_back(overlap);
    sum += overlap;
  }
  if (sum <= 0) return {out.first, {1.0}};
  for (double& weight : out.weight) weight /= sum;
  return out;
}

AxisWeights interpolate(double centre, int count) {
  const double place = std::clamp(centre, 0.0, count - 1.0);
  const int low = static_cast<int>(place);
  const double fraction = place - low;
  if (fraction < kRounding) return {low, {1.0}};
  return {low, {1 - fraction, fraction}};
}

std::vector<AxisWeights> axis_weights(const Lattice& image, const VoxelGrid& grid, int axis) {
  std::vector<AxisWeights> out;
  out.reserve(static_cast<std::size_t>(grid.dims[axis]));
  const double length = grid.voxel_mm / image.spacing_mm[axis];
  const bool averages = grid.voxel_mm >= image.spacing_mm[axis] * (1 - kRounding);
  for (int n = 0; n < grid.dims[axis]; ++n) {
    const double from = faces_from_mm(image, grid.origin_mm[axis] + n * grid.voxel_mm, axis);
    out.push_back(averages ? average(from, from + length, image.dims[axis])
                           : interpolate(from + 0.5 * length - 0.5, image.dims[axis]));
  }
  return out;
}

}  // namespace

double interpolated(const std::vector<float>& value, const Vec3i& dims, const Vec3& index) {
  const Vec3 inside = index.cwiseMax(0).cwiseMin((dims - Vec3i::Ones()).cast<double>());
  const Vec3i low = inside.cast<int>().cwiseMin((dims - Vec3i::Constant(2)).cwiseMax(0));
  double sum = 0;
  for_each_trilinear_weight(inside - low.cast<double>(), [&](const Vec3i& step, double weight) {
    sum += weight * double{value[index_in(dims, low + step)]};
  });
  return sum;
}

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
  const auto lps_axis = dominant_axes(geometry.step_mm);
  if (!lps_axis) return false;
  const double smallest = geometry.spacing_mm().minCoeff();
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 drift = geometry.step_mm.col(axis) * (geometry.dims[axis] - 1);
    drift[(*lps_axis)[axis]] = 0;
    if (drift.cwiseAbs().maxCoeff() > kAlignedTolerance_voxels * smallest) return false;
  }
  return true;
}

IndexBox voxels_in_crop(const ScanGeometry& geometry, const CtSettings& settings) {
  const bool aligned = is_axis_aligned(geometry);
  const Aabb box = cropped(geometry.bounds_mm(), settings);
  if (box.empty()) return {};
  const Mat3 index_from_mm = geometry.step_mm.inverse();
  Aabb indices = Aabb::none();
  for (int corner = 0; corner < 8; ++corner) {
    indices.extend(index_from_mm * (box.corner(corner) - geometry.origin_mm));
  }
  const double slack = aligned ? -kAlignedTolerance_voxels : -1;
  const Eigen::Array3d low = (indices.min.array() + slack).max(-1);
  const Eigen::Array3d high = (indices.max.array() - slack).min(geometry.dims.cast<double>().array());
  const Vec3i start = low.ceil().cast<int>().max(0);
  const Vec3i last = high.floor().cast<int>().min(geometry.dims.array() - 1);
  return {start, (last - start + Vec3i::Ones()).cwiseMax(0)};
}

AlignedImage align_to_lps(const Scan& scan, const CtSettings& settings, float outside, Interpolation by) {
  return is_axis_aligned(scan.geometry) ? permute(scan) : resample_oblique(scan, settings, outside, by);
}

SliceResampler::SliceResampler(const AlignedImage& image, const VoxelGrid& grid) : image_(image) {
  for (int axis = 0; axis < 3; ++axis) weights_[axis] = axis_weights(image.lattice, grid, axis);
}

std::vector<double> SliceResampler::slice(int k) const {
  const Lattice& image = image_.lattice;
  const auto nx = static_cast<std::size_t>(image.dims.x());
  std::vector<double> plane(nx * static_cast<std::size_t>(image.dims.y())), rows(nx * weights_[1].size());
  const AxisWeights& along_z = weights_[2][static_cast<std::size_t>(k)];
  for (std::size_t n = 0; n < along_z.weight.size(); ++n) {
    const float* from = &image_.value[image.index({0, 0, along_z.first + static_cast<int>(n)})];
    for (std::size_t at = 0; at < plane.size(); ++at) plane[at] += along_z.weight[n] * static_cast<double>(from[at]);
  }
  for (std::size_t j = 0; j < weights_[1].size(); ++j) {
    const AxisWeights& along_y = weights_[1][j];
    for (std::size_t n = 0; n < along_y.weight.size(); ++n) {
      const double* from = &plane[nx * (static_cast<std::size_t>(along_y.first) + n)];
      for (std::size_t i = 0; i < nx; ++i) rows[nx * j + i] += along_y.weight[n] * from[i];
    }
  }
  const std::size_t width = weights_[0].size();
  std::vector<double> out(width * weights_[1].size());
  for (std::size_t j = 0; j < weights_[1].size(); ++j) {
    for (std::size_t i = 0; i < width; ++i) {
      const AxisWeights& along_x = weights_[0][i];
      const double* from = &rows[nx * j + static_cast<std::size_t>(along_x.first)];
      double sum = 0;
      for (std::size_t n = 0; n < along_x.weight.size(); ++n) sum += along_x.weight[n] * from[n];
      out[width * j + i] = sum;
    }
  }
  return out;
}

double SliceResampler::at(const Vec3i& voxel) const {
  const auto weights = [&](int axis) -> const AxisWeights& {
    return weights_[axis][static_cast<std::size_t>(voxel[axis])];
  };
  const AxisWeights &x = weights(0), &y = weights(1), &z = weights(2);
  double sum = 0;
  for (std::size_t k = 0; k < z.weight.size(); ++k) {
    for (std::size_t j = 0; j < y.weight.size(); ++j) {
      const float* row =
          &image_.value[image_.lattice.index({x.first, y.first + static_cast<int>(j), z.first + static_cast<int>(k)})];
      for (std::size_t i = 0; i < x.weight.size(); ++i) {
        sum += z.weight[k] * y.weight[j] * x.weight[i] * static_cast<double>(row[i]);
      }
    }
  }
  return sum;
}

NegatedField::NegatedField(const AlignedImage& image)
    : values_(image.value.data()),
      origin_mm_(image.lattice.origin_mm),
      spacing_mm_(image.lattice.spacing_mm),
      last_(image.lattice.dims.cast<double>() - Vec3::Ones()),
      last_low_((image.lattice.dims - Vec3i::Constant(2)).cwiseMax(0)),
      stride_{1, image.lattice.index({0, 1, 0}), image.lattice.index({0, 0, 1})} {
  for (int axis = 0; axis < 3; ++axis) step_[axis] = image.lattice.dims[axis] > 1 ? stride_[axis] : 0;
}

}  // namespace reamsim::ct
