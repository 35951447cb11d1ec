// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/verify/push_closed_forms.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace reamsim::verify {

using std::numbers::pi;

namespace {

SteadyPlunge with_feed(SteadyPlunge head, double feed_mm_s) {
  head.feed_mm_s = feed_mm_s;
  return head;
}

/// B of A·v + B·v² = F.
double square_resistance(const SteadyPlunge& head) {
  const double omega = angular_speed(head.rpm);
  return 2 * pi * specific_energy(head.density_g_cm3) * std::log(head.outer_mm / head.bore_mm) / (omega * omega);
}

/// The argument in (0, most) where an increasing function has a value; `most` where it is below that.
double root(const std::function<double(double)>& f, double value, double most) {
  if (f(most) <= value) return most;
  double low = 0, high = most;
  for (int i = 0; i < 60; ++i) (f((low + high) / 2) < value ? low : high) = (low + high) / 2;
  return (low + high) / 2;
}

/// Simpson's rule.
double integral(const std::function<double(double)>& f, double from, double to, int parts) {
  const double step = (to - from) / parts;
  double sum = 0;
  for (int i = 0; i <= parts; ++i) sum += (i == 0 || i == parts ? 1 : i % 2 == 1 ? 4 : 2) * f(from + i * step);
  return sum * step / 3;
}

/// Axial force on the face out to `radius_mm`, with the speed floor.
double thrust_within(const SteadyPlunge& head, double feed, double radius_mm) {
  const double u = specific_energy(head.density_g_cm3), omega = angular_speed(head.rpm), face = *head.radius_mm;
  const auto ring = [&](double r) {
    const double slope = std::sqrt(1 - r * r / (face * face)), speed = std::hypot(omega * r, feed);
    const double tangential = u * feed * r / std::max(speed, kSpeedFloor_mm_s), into = feed * slope / speed;
    return 2 * pi * tangential * (feed / speed + kNormalRatio * (slope - into * feed / speed));
  };
  const double floor_mm = std::sqrt(kSpeedFloor_mm_s * kSpeedFloor_mm_s - feed * feed) / omega;
  constexpr int kParts = 64;
  const double inner = std::min(floor_mm, radius_mm);
  return integral(ring, 0, inner, kParts) + (radius_mm > inner ? integral(ring, inner, radius_mm, kParts) : 0);
}

}  // namespace

double linear_resistance(const SteadyPlunge& head) {
  // The thrust at a feed is A·v + B·v².
  const double feed = 1;
  return with_feed(head, feed).axial_force_n() / feed - square_resistance(head) * feed;
}

double quadratic_feed(const SteadyPlunge& head, double thrust_n) {
  const double a = linear_resistance(head), b = square_resistance(head);
  return 2 * thrust_n / (a + std::sqrt(a * a + 4 * b * thrust_n));
}

double balanced_feed_of(const SteadyPlunge& head, double thrust_n) {
  constexpr double kMost_mm_s = 100;
  return root([&](double feed) { return with_feed(head, feed).full_loads().axial_force_n; }, thrust_n, kMost_mm_s);
}

double time_to_depth_s(const SteadyPlunge& head, double thrust_n, double max_feed_mm_s, double depth_mm) {
  const auto feed_at = [&](double depth) {
    const double radius = std::sqrt(2 * *head.radius_mm * depth - depth * depth);
    return root([&](double feed) { return thrust_within(head, feed, radius); }, thrust_n, max_feed_mm_s);
  };
  // The feed is limited at first; the square root makes the integrand smooth.
  const double limited_mm = root(
      [&](double depth) {
        const double radius = std::sqrt(2 * *head.radius_mm * depth - depth * depth);
        return thrust_within(head, max_feed_mm_s, radius);
      },
      thrust_n, depth_mm);
  if (limited_mm >= depth_mm) return depth_mm / max_feed_mm_s;
  const auto per_root = [&](double x) { return 2 * x / feed_at(x * x); };
  return limited_mm / max_feed_mm_s + integral(per_root, std::sqrt(limited_mm), std::sqrt(depth_mm), 64);
}

double travel_of_mass_mm(const SteadyPlunge& head, double thrust_n, double mass_kg, double time_s) {
  // The equation of Riccati with constant coefficients: v = w·tanh(k·t + c) − A/(2B) with w = √(A² + 4BF)/(2B).
  const double a = linear_resistance(head), b = square_resistance(head), mass = 1e-3 * mass_kg;
  const double w = std::sqrt(a * a + 4 * b * thrust_n) / (2 * b), half = a / (2 * b);
  const double rate = b * w / mass, phase = std::atanh(half / w);
  return w / rate * std::log(std::cosh(rate * time_s + phase) / std::cosh(phase)) - half * time_s;
}

}  // namespace reamsim::verify
