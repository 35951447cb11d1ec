// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>

#include "sim/base/geometry.h"

namespace reamsim {

namespace noise_detail {

inline std::uint64_t mixed(std::uint64_t bits) {  // finalizer of splitmix64
  bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9ULL;
  bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBULL;
  return bits ^ (bits >> 31);
}

/// The value at a lattice point: 53 bits mapped to −1…1.
inline double corner(const Vec3i& c, std::uint32_t seed) {
  std::uint64_t bits = mixed(seed + 0x9E3779B97F4A7C15ULL);
  for (int axis = 0; axis < 3; ++axis) bits = mixed(bits ^ static_cast<std::uint32_t>(c[axis]));
  return static_cast<double>(bits >> 11) * 0x1p-52 - 1;
}

inline double lerp(double a, double b, double t) {
  return a + t * (b - a);
}

}  // namespace noise_detail

/// Smooth noise in −1…1: hashed integers at the corners of a unit lattice, blended with a quintic that has continuous
/// second derivatives. The same on every machine.
inline double value_noise(const Vec3& point, std::uint32_t seed) {
  using noise_detail::corner, noise_detail::lerp;
  const Vec3 below = point.array().floor();
  const Vec3i cell = below.cast<int>();
  const Vec3 t = (point - below).unaryExpr([](double s) { return s * s * s * (s * (6 * s - 15) + 10); });
  double planes[2];
  for (int k = 0; k < 2; ++k) {
    double rows[2];
    for (int j = 0; j < 2; ++j) {
      rows[j] = lerp(corner(cell + Vec3i(0, j, k), seed), corner(cell + Vec3i(1, j, k), seed), t.x());
    }
    planes[k] = lerp(rows[0], rows[1], t.y());
  }
  return lerp(planes[0], planes[1], t.z());
}

}  // namespace reamsim
