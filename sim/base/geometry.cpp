// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/geometry.h"

#include <cmath>

namespace reamsim {

Quat smallest_rotation(const Vec3& from, const Vec3& to) {
  const Vec3 start = from.normalized(), end = to.normalized();
  const double cosine = end.dot(start);
  if (cosine < -1 + 1e-12) {
    const Vec3 across = start.unitOrthogonal();
    return {0, across.x(), across.y(), across.z()};
  }
  // Half-angle formulas: |axis| is the sine, and twice_cosine / 2 the cosine of half the angle.
  const Vec3 axis = start.cross(end);
  const double twice_cosine = std::sqrt((1 + cosine) * 2);
  const double inverse = 1 / twice_cosine;
  return {twice_cosine * 0.5, axis.x() * inverse, axis.y() * inverse, axis.z() * inverse};
}

}  // namespace reamsim
