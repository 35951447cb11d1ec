#include "sim/base/geometry.h"

#include <Eigen/SVD>

namespace reamsim {

Quat smallest_rotation(const Vec3& from, const Vec3& to) {
  return Quat::FromTwoVectors(from, to);
}

}  // namespace reamsim
