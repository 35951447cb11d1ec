// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/base/parallel.h"
#include "sim/scan/segment.h"

namespace reamsim::ct {

namespace {

/// One iteration of the modified curvature diffusion equation (Whitaker and Xue 2001, Proc. ICIP 3:142), discretised as
/// in itk::CurvatureNDAnisotropicDiffusionFunction, which evaluates each face twice and takes twice the time.
class CurvatureDiffusion {
 public:
  CurvatureDiffusion(const AlignedImage& image, double conductance)
      : value_(image.value.data()), dims_(image.lattice.dims), scale_(image.lattice.spacing_mm.cwiseInverse()) {
    const float exponent = static_cast<float>(mean_squared_gradient() * conductance * conductance * -2);
    flat_ = exponent == 0;
    exponent_ = double{exponent};
  }

  /// The change of the voxels of slices `begin`…`end` − 1 over that of the time.
  void rate(int begin, int end, std::vector<float>& out) const {
    // What flows in through the lower face of a voxel has flowed out of the voxel below it.
    std::vector<double> under(static_cast<std::size_t>(stride_[2]), 0.0), before(static_cast<std::size_t>(dims_.x()));
    if (begin > 0) {
      for_each_voxel({0, 0, begin - 1}, {dims_.x() - 1, dims_.y() - 1, begin - 1}, [&](const Vec3i& v) {
        under[static_cast<std::size_t>(v.x() + stride_[1] * v.y())] = outflow(v, offset(v), 2);
      });
    }
    Vec3 inflow = Vec3::Zero();
    for_each_voxel({0, 0, begin}, {dims_.x() - 1, dims_.y() - 1, end - 1}, [&](const Vec3i& v) {
      const std::ptrdiff_t at = offset(v);
      double& in_y = before[static_cast<std::size_t>(v.x())];
      double& in_z = under[static_cast<std::size_t>(v.x() + stride_[1] * v.y())];
      inflow = {v.x() == 0 ? 0 : inflow.x(), v.y() == 0 ? 0 : in_y, in_z};
      const Vec3 outward(outflow(v, at, 0), outflow(v, at, 1), outflow(v, at, 2));
      double speed = 0;
      for (int axis = 0; axis < 3; ++axis) speed += outward[axis] - inflow[axis];
      out[static_cast<std::size_t>(at)] = static_cast<float>(upwind_gradient(v, at, speed > 0) * speed);
      inflow = outward;
      in_y = outward.y();
      in_z = outward.z();
    });
  }

 private:
  [[nodiscard]] std::ptrdiff_t offset(const Vec3i& v) const { return v.x() + stride_[1] * v.y() + stride_[2] * v.z(); }
  // The steps to the neighbours along an axis; beyond the image the value of its border holds.
  [[nodiscard]] std::ptrdiff_t up(const Vec3i& v, int axis) const {
    return v[axis] + 1 < dims_[axis] ? stride_[axis] : 0;
  }
  [[nodiscard]] std::ptrdiff_t down(const Vec3i& v, int axis) const { return v[axis] > 0 ? stride_[axis] : 0; }

  [[nodiscard]] double mean_squared_gradient() const {
    std::vector<double> sums(static_cast<std::size_t>(dims_.z()), 0.0);
    parallel_items(sums.size(), [&](std::size_t slice) {
      const int z = static_cast<int>(slice);
      for_each_voxel({0, 0, z}, {dims_.x() - 1, dims_.y() - 1, z}, [&](const Vec3i& v) {
        const std::ptrdiff_t at = offset(v);
        for (int axis = 0; axis < 3; ++axis) {
          const float across = value_[at + up(v, axis)] - value_[at - down(v, axis)];
          const double central = double{across} / 2 * scale_[axis];
          sums[slice] += central * central;
        }
      });
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0) /
           static_cast<double>(std::int64_t{1} * dims_.x() * dims_.y() * dims_.z());
  }

  /// The normalised gradient through the upper face of a voxel along an axis, times its conductance.
  [[nodiscard]] double outflow(const Vec3i& v, std::ptrdiff_t at, int axis) const {
    constexpr double kLeast = 1e-10;
    const std::ptrdiff_t next = up(v, axis);
    if (flat_ || next == 0) return 0;
    const double along = double{value_[at + next] - value_[at]} * scale_[axis];
    double squared = along * along;
    for (int across = 0; across < 3; ++across) {
      if (across == axis) continue;
      const std::ptrdiff_t above = up(v, across), below = -down(v, across);
      const auto central = [&](std::ptrdiff_t place) {
        return double{(value_[place + above] - value_[place + below]) / 2} * scale_[across];
      };
      const double both = central(at) + central(at + next);
      squared += 0.25 * both * both;
    }
    return along / std::sqrt(kLeast + squared) * std::exp(squared / exponent_);
  }

  /// |∇f| by one-sided differences, upwind by the sign of the speed.
  [[nodiscard]] double upwind_gradient(const Vec3i& v, std::ptrdiff_t at, bool rising) const {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double forward = double{value_[at + up(v, axis)] - value_[at]} * scale_[axis];
      const double backward = double{value_[at] - value_[at - down(v, axis)]} * scale_[axis];
      const double in = rising ? std::min(backward, 0.0) : std::max(backward, 0.0);
      const double out = rising ? std::max(forward, 0.0) : std::min(forward, 0.0);
      sum += in * in + out * out;
    }
    return std::sqrt(sum);
  }

  const float* value_;
  Vec3i dims_;
  Vec3 scale_;  ///< 1/mm
  std::ptrdiff_t stride_[3] = {1, dims_.x(), std::ptrdiff_t{1} * dims_.x() * dims_.y()};
  bool flat_;
  double exponent_;  ///< of the conductance: exp(|∇|² / exponent_)
};

}  // namespace

void curvature_anisotropic_filter(AlignedImage& image, int iterations, double conductance) {
  constexpr double kStableFraction = 1.0 / 16;  // of the least spacing: 1/2^(3+1), for three dimensions
  const double step = kStableFraction * image.lattice.spacing_mm.minCoeff();
  constexpr std::size_t kSlices = 8;  // a range computes the faces below it again
  std::vector<float> rate(image.value.size());
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const CurvatureDiffusion diffusion(image, conductance);
    parallel_ranges(static_cast<std::size_t>(image.lattice.dims.z()), kSlices, [&](std::size_t begin, std::size_t end) {
      diffusion.rate(static_cast<int>(begin), static_cast<int>(end), rate);
    });
    std::ranges::transform(image.value, rate, image.value.begin(), [&](float value, float change) {
      return value + static_cast<float>(double{change} * step);
    });
  }
}

}  // namespace reamsim::ct
