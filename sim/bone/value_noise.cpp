#include "sim/bone/value_noise.h"

#include <cmath>

namespace reamsim {

namespace {

std::uint64_t mixed(std::uint64_t bits) {  // finaliser of splitmix64
  bits = (bits ^ (bits >> 30)) * 0xBF58476D1CE4E5B9ULL;
  bits = (bits ^ (bits >> 27)) * 0x94D049BB133111EBULL;
  return bits ^ (bits >> 31);
}

double corner(const Vec3i& c, std::uint32_t seed) {
  std::uint64_t bits = mixed(seed + 0x9E3779B97F4A7C15ULL);
  for (int axis = 0; axis < 3; ++axis) bits = mixed(bits ^ static_cast<std::uint32_t>(c[axis]));
  return static_cast<double>(bits >> 11) * 0x1p-52 - 1;  // 53 bits onto −1…1
}

double fade(double t) {
  return t * t * t * (t * (6 * t - 15) + 10);
}

double lerp(double a, double b, double t) {
  return a + t * (b - a);
}

}  // namespace

double value_noise(const Vec3& point, std::uint32_t seed) {
  const Vec3 below = point.array().floor();
  const Vec3i cell = below.cast<int>();
  const Vec3 t = (point - below).unaryExpr(&fade);
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
