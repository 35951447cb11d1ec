#pragma once

#include <algorithm>
#include <cmath>

#include "kernels/cube_share.h"
#include "sim/base/geometry.h"
#include "sim/bone/voxmap/field_cross.h"

namespace reamsim {

/// Halvings of a voxel in which a surface has an edge, at most: 64 parts.
inline constexpr int kMaxSplits = 2;

/// A field round the middle of a cube, in sides of the cube.
struct FieldStencil {
  double value = 0;
  Vec3 slope = Vec3::Zero();
  double bend = 0;  ///< second differences, all directions together
  double kink = 0;  ///< how much the slopes on either side differ

  /// Whether the surface may pass for a plane that is bent a little.
  [[nodiscard]] bool smooth() const { return kink <= 0.5 * slope.norm(); }
};

/// Central differences over `step`.
template <class Field>
FieldStencil field_stencil(const Field& field, const Vec3& center, double side, double step) {
  const FieldSamples cross = sample_along_axes(field, center, step);
  FieldStencil out;
  out.value = cross.center;
  const double sides = side / step;
  for (int axis = 0; axis < 3; ++axis) {
    const double before = cross.before[axis], after = cross.after[axis];
    const double second = before + after - 2 * out.value;
    out.slope[axis] = 0.5 * (after - before) * sides;
    out.bend += second * sides * sides;
    out.kink += std::abs(second) * sides;
  }
  return out;
}

/// Part of a cube where the field is negative, with the surface as a plane. A surface that bulges falls away from its
/// plane by the mean of t²/2 times its curvature, over the cube 1/24 in each direction (as rs_fill_outside()).
inline double plane_fraction(const FieldStencil& at) {
  const double length = at.slope.norm();
  if (length < 1e-12 * std::abs(at.value) || length == 0) return at.value < 0 ? 1 : 0;
  const double curvature = std::clamp(at.bend / length, -1.0, 1.0);
  const double away = at.value / length + curvature / 24;
  if (std::abs(away) > RS_CLIP_REACH) return away < 0 ? 1 : 0;
  const Vec3 normal = at.slope / length;
  const float n[3] = {static_cast<float>(normal.x()), static_cast<float>(normal.y()), static_cast<float>(normal.z())};
  return double{rs_outside_share(n, static_cast<float>(-away))};
}

/// Part of a cube, 0…1, in which `field` is negative. The field is any continuous function of a point that falls about
/// evenly through its surface, such as a signed distance; where an edge or a thin wall makes it fall unevenly, and in
/// any case for the first `least_splits` times, the cube is halved along each axis.
/// @param center, side  of the cube, in the field's coordinates
template <class Field>
double fraction_inside(const Field& field, const Vec3& center, double side, int least_splits = 0, int split = 0) {
  if (split >= least_splits) {
    // A whole voxel looks as far as its neighbours' centres, where a field given by voxels is known best; a part of one
    // no further than its own faces.
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
