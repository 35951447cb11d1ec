// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/study_plan.h"

#include <array>
#include <boost/math/distributions/normal.hpp>
#include <boost/random/sobol.hpp>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace reamsim {

namespace {

using Points = std::vector<std::vector<double>>;

/// SplitMix64 (Steele, Lea and Flood 2014), the same on every machine, unlike distributions of the standard library.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

std::uint64_t random_bits(std::uint64_t seed, std::uint64_t dimension, std::uint64_t i) {
  return mixed(mixed(mixed(seed) + dimension) + i);
}

/// A number in the open interval (0, 1) from 53 of 64 bits.
double unit(std::uint64_t bits) {
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

Points monte_carlo(int n, int dimensions, std::uint64_t seed) {
  Points points(static_cast<std::size_t>(n), std::vector<double>(static_cast<std::size_t>(dimensions)));
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t d = 0; d < points[i].size(); ++d) points[i][d] = unit(random_bits(seed, d, i));
  }
  return points;
}

Points latin_hypercube(int n, int dimensions, std::uint64_t seed) {
  Points points = monte_carlo(n, dimensions, seed);  // the place within the interval
  std::vector<std::size_t> order(points.size());
  for (std::size_t d = 0; d < static_cast<std::size_t>(dimensions); ++d) {
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = order.size(); i > 1; --i) {  // Fisher and Yates
      std::swap(order[i - 1], order[random_bits(seed ^ 0x4c4853, d, i) % i]);
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i][d] = (static_cast<double>(order[i]) + points[i][d]) / static_cast<double>(n);
    }
  }
  return points;
}

Points sobol(int n, int dimensions, std::uint64_t seed) {
  Points points(static_cast<std::size_t>(n), std::vector<double>(static_cast<std::size_t>(dimensions)));
  try {
    boost::random::sobol sequence(static_cast<std::size_t>(dimensions));
    for (std::vector<double>& point : points) {
      for (std::size_t d = 0; d < point.size(); ++d) point[d] = unit(sequence() ^ random_bits(seed, d, 0));
    }
  } catch (const std::range_error&) {
    throw InputError({}, "sample.of", std::to_string(dimensions) + " sampled numbers", "use method: latin_hypercube");
  }
  return points;
}

Points saltelli(int n, int dimensions, std::uint64_t seed) {
  Points points;
  for (const std::vector<double>& both : sobol(n, 2 * dimensions, seed)) {
    const std::vector<double> a(both.begin(), both.begin() + dimensions), b(both.begin() + dimensions, both.end());
    points.push_back(a);
    points.push_back(b);
    for (std::size_t d = 0; d < a.size(); ++d) {
      points.push_back(a);
      points.back()[d] = b[d];
    }
  }
  return points;
}

}  // namespace

Points unit_points(SampleMethod method, int n, int dimensions, std::uint64_t seed) {
  static constexpr std::array kMethods{sobol, latin_hypercube, monte_carlo, saltelli};  // as SampleMethod
  return kMethods[static_cast<std::size_t>(method)](n, dimensions, seed);
}

int Distribution::dimensions() const {
  if (kind == Kind::tilt_sd_deg) return 2;
  return kind == Kind::shift_sd_mm ? 3 : 1;
}

double normal_quantile(double u) {
  return boost::math::quantile(boost::math::normal(), u);
}

double sample_number(const Distribution& distribution, double u) {
  const auto [kind, a, b] = distribution;
  if (kind == Distribution::Kind::uniform) return a + (b - a) * u;
  const double z = normal_quantile(u);
  return kind == Distribution::Kind::lognormal ? a * std::exp(b * z) : a + b * z;
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
