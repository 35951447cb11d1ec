// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/base/geometry.h"

#include <Eigen/SVD>

namespace reamsim {

Quat smallest_rotation(const Vec3& from, const Vec3& to) {
  return Quat::FromTwoVectors(from, to);
}

}  // namespace reamsim
