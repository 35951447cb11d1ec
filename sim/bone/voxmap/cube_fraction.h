// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cmath>

#include "kernels/cube_fraction.h"
#include "sim/base/geometry.h"

namespace reamsim {

inline constexpr int kMaxSplits = 2;  ///< a surface with an edge halves a voxel at most this often: 64 parts

/// Derivatives of a field at the centre of a cube. The unit of length is the side of the cube.
struct FieldStencil {
  double value = 0;
  Vec3 gradient = Vec3::Zero();
  double laplacian = 0;
  double kink = 0;  ///< difference of the one-sided slopes, summed over the axes

  /// Whether a slightly curved plane approximates the surface.
  [[nodiscard]] bool smooth() const { return kink <= 0.5 * gradient.norm(); }
};

/// A field at a point, and a step before and after it along each axis.
struct SevenPoints {
  double center, before[3], after[3];
};
template <class Field>
SevenPoints seven_points(const Field& field, const Vec3& center, double step) {
  const auto at = [&](int axis, double offset) { return field(center + offset * Vec3::Unit(axis)); };
  return {field(center), {at(0, -step), at(1, -step), at(2, -step)}, {at(0, step), at(1, step), at(2, step)}};
}

/// Central differences over `step`.
template <class Field>
FieldStencil field_stencil(const Field& field, const Vec3& center, double side, double step) {
  const SevenPoints at = seven_points(field, center, step);
  FieldStencil out;
  out.value = at.center;
  const double sides = side / step;
  for (int axis = 0; axis < 3; ++axis) {
    const double before = at.before[axis], after = at.after[axis];
    const double second = before + after - 2 * out.value;
    out.gradient[axis] = 0.5 * (after - before) * sides;
    out.laplacian += second * sides * sides;
    out.kink += std::abs(second) * sides;
  }
  return out;
}

/// The fraction of a cube in which the field is negative, with the surface as a plane. A convex surface recedes from
/// its tangent plane by the mean of t²/2 times its curvature: 1/24 of it in each direction (as in rs_fill_outside()).
inline double plane_fraction(const FieldStencil& at) {
  const double length = at.gradient.norm();
  if (length < 1e-12 * std::abs(at.value) || length == 0) return at.value < 0 ? 1 : 0;
  const double curvature = std::clamp(at.laplacian / length, -1.0, 1.0);
  const double distance = at.value / length + curvature / 24;
  if (std::abs(distance) > RS_CLIP_REACH) return distance < 0 ? 1 : 0;
  const Vec3 normal = at.gradient / length;
  const float n[3] = {static_cast<float>(normal.x()), static_cast<float>(normal.y()), static_cast<float>(normal.z())};
  return double{rs_outside_fraction(n, static_cast<float>(-distance))};
}

/// The fraction of a cube that lies in a box.
inline double fraction_in_box(const Aabb& box, const Vec3& center, double side) {
  const Vec3 half = Vec3::Constant(side / 2);
  const Vec3 common = (center + half).cwiseMin(box.max) - (center - half).cwiseMax(box.min);
  return (common.cwiseMax(0) / side).prod();
}

/// The fraction, 0…1, of a cube in which `field` is negative: a continuous function of a point, such as a signed
/// distance, with a nearly constant slope across its surface. Where an edge or a thin wall breaks that, and in any case
/// `least_splits` times, the cube is halved along each axis; `split` counts these halvings.
template <class Field>
double fraction_inside(const Field& field, const Vec3& center, double side, int least_splits = 0, int split = 0) {
  if (split >= least_splits) {
    // A voxel is sampled at its neighbours' centres, where a field of voxels is most accurate; a part at its own faces.
    const FieldStencil at = field_stencil(field, center, side, split == 0 ? side : 0.5 * side);
    if (at.smooth() || split >= std::max(kMaxSplits, least_splits)) return plane_fraction(at);
  }
  double sum = 0;
  for (int part = 0; part < 8; ++part) {
    const Vec3 step(part & 1 ? 0.25 : -0.25, part & 2 ? 0.25 : -0.25, part & 4 ? 0.25 : -0.25);
    sum += fraction_inside(field, center + side * step, 0.5 * side, least_splits, split + 1);
  }
  return sum / 8;
}

}  // namespace reamsim
