// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scan/resample.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/bone/voxmap/sparse_bricks.h"

namespace reamsim::ct {

namespace {

/// Tolerance of whole numbers; coordinates of real scans are rounded.
constexpr double kRounding = 1e-6;
constexpr double kMaxSamples = 16;  // of one voxel along one axis

/// Position along an axis in image voxels: 0 is the lower face of voxel 0, 1 its upper face.
double faces_from_mm(const Lattice& image, double mm, int axis) {
  return (mm - image.origin_mm[axis]) / image.spacing_mm[axis] + 0.5;
}

AxisWeights average(double from, double to, int count) {
  const double low = std::clamp<double>(from, 0, count - 1);
  const double high = std::clamp<double>(to, low, count);
  AxisWeights out;
  out.first = static_cast<int>(std::floor(low + kRounding));
  out.first = std::min(out.first, count - 1);
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

}  // namespace

VoxelGrid grid_around(const Lattice& image, const Vec3i& min, const Vec3i& max, double voxel_mm, int margin_voxels) {
  const Vec3 corner = image.bounds_mm().min;
  VoxelGrid grid;
  grid.voxel_mm = voxel_mm;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::floor(min[axis] * image.spacing_mm[axis] / voxel_mm + kRounding) - margin_voxels;
    const double high = std::ceil((max[axis] + 1) * image.spacing_mm[axis] / voxel_mm - kRounding) + margin_voxels;
    const double bricks = std::ceil((high - low) / FillBricks::kSide);
    if (bricks * FillBricks::kSide > std::numeric_limits<int>::max()) throw std::length_error("voxel grid");
    grid.dims[axis] = static_cast<int>(bricks) * FillBricks::kSide;
    grid.origin_mm[axis] = corner[axis] + low * voxel_mm;
  }
  return grid;
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

SliceResampler::SliceResampler(const AlignedImage& image, const VoxelGrid& grid) : image_(image), grid_(grid) {
  for (int axis = 0; axis < 3; ++axis) weights_[axis] = axis_weights(image.lattice, grid, axis);
  const auto nx = static_cast<std::size_t>(image.lattice.dims.x());
  plane_.resize(nx * static_cast<std::size_t>(image.lattice.dims.y()));
  rows_.resize(nx * static_cast<std::size_t>(grid.dims.y()));
  out_.resize(static_cast<std::size_t>(grid.dims.x()) * static_cast<std::size_t>(grid.dims.y()));
}

const std::vector<double>& SliceResampler::slice(int k) {
  const Lattice& image = image_.lattice;
  const auto nx = static_cast<std::size_t>(image.dims.x());
  std::fill(plane_.begin(), plane_.end(), 0.0);
  const AxisWeights& along_z = weights_[2][static_cast<std::size_t>(k)];
  for (std::size_t n = 0; n < along_z.weight.size(); ++n) {
    const float* from = &image_.value[image.index({0, 0, along_z.first + static_cast<int>(n)})];
    for (std::size_t at = 0; at < plane_.size(); ++at) plane_[at] += along_z.weight[n] * static_cast<double>(from[at]);
  }
  std::fill(rows_.begin(), rows_.end(), 0.0);
  for (std::size_t j = 0; j < weights_[1].size(); ++j) {
    const AxisWeights& along_y = weights_[1][j];
    for (std::size_t n = 0; n < along_y.weight.size(); ++n) {
      const double* from = &plane_[nx * (static_cast<std::size_t>(along_y.first) + n)];
      for (std::size_t i = 0; i < nx; ++i) rows_[nx * j + i] += along_y.weight[n] * from[i];
    }
  }
  const std::size_t width = weights_[0].size();
  for (std::size_t j = 0; j < weights_[1].size(); ++j) {
    for (std::size_t i = 0; i < width; ++i) {
      const AxisWeights& along_x = weights_[0][i];
      const double* from = &rows_[nx * j + static_cast<std::size_t>(along_x.first)];
      double sum = 0;
      for (std::size_t n = 0; n < along_x.weight.size(); ++n) sum += along_x.weight[n] * from[n];
      out_[width * j + i] = sum;
    }
  }
  return out_;
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
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    step_[at] = image.lattice.dims[axis] > 1 ? stride_[at] : 0;
  }
}

InsideTest::InsideTest(const AlignedImage& field, const VoxelGrid& grid) : field_(field) {
  const Lattice& image = field.lattice;
  for (int axis = 0; axis < 3; ++axis) {
    const double length = grid.voxel_mm / image.spacing_mm[axis];
    // Two samples per image voxel, up to a limit.
    const double wanted = length > 1 + kRounding ? 2 * std::ceil(length - kRounding) : 1;
    samples_[axis] = static_cast<int>(std::min(wanted, kMaxSamples));
    for (int n = 0; n < grid.dims[axis] * samples_[axis]; ++n) {
      const double mm = grid.origin_mm[axis] + grid.voxel_mm * (n + 0.5) / samples_[axis];
      const double place = std::clamp(faces_from_mm(image, mm, axis) - 0.5, 0.0, image.dims[axis] - 1.0);
      const int low = std::min(static_cast<int>(place), std::max(image.dims[axis] - 2, 0));
      sample_[axis].push_back({low, static_cast<float>(place - low)});
    }
  }
}

bool InsideTest::inside(const Sample& x, const Sample& y, const Sample& z) const {
  const Lattice& image = field_.lattice;
  const std::size_t step_x = image.dims.x() > 1 ? 1 : 0;
  const std::size_t step_y = image.dims.y() > 1 ? static_cast<std::size_t>(image.dims.x()) : 0;
  const std::size_t step_z = image.dims.z() > 1 ? image.index({0, 0, 1}) : 0;
  const float* corner = &field_.value[image.index({x.low, y.low, z.low})];
  const auto along_x = [&](std::size_t at) { return corner[at] + x.fraction * (corner[at + step_x] - corner[at]); };
  const auto along_y = [&](std::size_t at) {
    const float low = along_x(at);
    return low + y.fraction * (along_x(at + step_y) - low);
  };
  const float low = along_y(0);
  return low + z.fraction * (along_y(step_z) - low) > 0;
}

bool InsideTest::operator()(const Vec3i& voxel) const {
  const Vec3i samples(samples_[0], samples_[1], samples_[2]);
  const Vec3i first = voxel.cwiseProduct(samples);
  const auto sample = [this](const Vec3i& s, int axis) { return sample_[axis][static_cast<std::size_t>(s[axis])]; };
  int hits = 0;
  for_each_voxel(first, first + samples - Vec3i::Ones(),
                 [&](const Vec3i& s) { hits += inside(sample(s, 0), sample(s, 1), sample(s, 2)); });
  return 2 * hits >= samples.prod() && hits > 0;
}

}  // namespace reamsim::ct
