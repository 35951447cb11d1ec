#pragma once

#include <cstdint>

#include "sim/base/geometry.h"

namespace reamsim {

/// Smooth noise in −1…1: hashed integers at the corners of a unit lattice, blended with a quintic that has continuous
/// second derivatives. The same on every machine and in any order.
double value_noise(const Vec3& point, std::uint32_t seed);

}  // namespace reamsim
