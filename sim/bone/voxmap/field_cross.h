#pragma once

#include "sim/base/geometry.h"

namespace reamsim {

/// A field at a point, and a step before and after it along each axis.
struct FieldSamples {
  double center = 0;
  Vec3 before = Vec3::Zero();
  Vec3 after = Vec3::Zero();
};

/// The field there, seven calls of it unless it has a shorter way of its own, `field.cross(center, step)`.
template <class Field>
FieldSamples sample_along_axes(const Field& field, const Vec3& center, double step) {
  if constexpr (requires { field.cross(center, step); }) {
    return field.cross(center, step);
  } else {
    FieldSamples out;
    out.center = field(center);
    for (int axis = 0; axis < 3; ++axis) {
      out.before[axis] = field(center - step * Vec3::Unit(axis));
      out.after[axis] = field(center + step * Vec3::Unit(axis));
    }
    return out;
  }
}

}  // namespace reamsim
