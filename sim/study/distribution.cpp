// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/distribution.h"

#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numbers>

namespace reamsim {

int Distribution::dimensions() const {
  if (kind == Kind::tilt_sd_deg) return 2;
  return kind == Kind::shift_sd_mm ? 3 : 1;
}

double normal_quantile(double u) {
  return boost::math::quantile(boost::math::normal(), u);
}

double sample_number(const Distribution& distribution, double u) {
  const auto [kind, a, b] = distribution;
  switch (kind) {
    case Distribution::Kind::lognormal:
      return a * std::exp(b * normal_quantile(u));
    case Distribution::Kind::uniform:
      return a + (b - a) * u;
    default:
      return a + b * normal_quantile(u);
  }
}

Vec3 tilted(const Vec3& direction, double a_deg, double b_deg) {
  const Vec3 unit = direction.normalized();
  const Vec3 aside = std::abs(unit.x()) < std::abs(unit.y()) ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 e1 = unit.cross(aside).normalized(), e2 = unit.cross(e1);
  const double angle_deg = std::hypot(a_deg, b_deg);
  if (angle_deg == 0) return unit;
  const Vec3 axis = (a_deg * e1 + b_deg * e2) / angle_deg;
  return Eigen::AngleAxisd(angle_deg * std::numbers::pi / 180, axis) * unit;
}

}  // namespace reamsim
