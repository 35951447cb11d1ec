// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/verify/closed_forms.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "sim/bone/implicit.h"

namespace reamsim::verify {

using std::numbers::pi;

CuttingSettings stated_cutting(ErosionMode erosion) {
  return {.law = CuttingLaw::energy,
          .erosion = erosion,
          .specific_energy_j_mm3 = kSpecificEnergy_mj_mm3 / 1000,
          .reference_density_g_cm3 = kReferenceDensity_g_cm3,
          .density_exponent = kDensityExponent,
          .normal_ratio = kNormalRatio,
          .speed_floor_mm_s = kSpeedFloor_mm_s};
}

double specific_energy(double density_g_cm3) {
  return kSpecificEnergy_mj_mm3 * std::pow(density_g_cm3 / kReferenceDensity_g_cm3, kDensityExponent);
}

double angular_speed(double rpm) {
  return 2 * pi * rpm / 60;
}

double cap_mm3(double radius_mm, double depth_mm) {
  return pi * depth_mm * depth_mm * (radius_mm - depth_mm / 3);
}

double segment_mm2(double radius_mm, double depth_mm) {
  const double above = radius_mm - depth_mm;
  return radius_mm * radius_mm * std::acos(above / radius_mm) -
         above * std::sqrt(radius_mm * radius_mm - above * above);
}

namespace {

/// C(r) of docs/physics.md, 6: ∫ cos θ dr along the face from the axis to r, with θ the slope of the face.
double face_integral(const SteadyPlunge& plunge, double r) {
  if (!plunge.radius_mm) return r;
  const double radius = *plunge.radius_mm;
  return 0.5 * (r * std::sqrt(1 - r * r / (radius * radius)) + radius * std::asin(r / radius));
}

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
  return implicit::bisect(0, most, 60, [&](double x) { return f(x) < value; }).middle();
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

constexpr double kRatio = 2;  // of one step to the next
constexpr double kFormalOrder = 2;
/// Below this observed order the levels are outside the asymptotic range.
constexpr double kLeastOrder = 0.5;
constexpr double kSafetyOfThree = 1.25, kSafetyOfTwo = 3;  // Roache

/// Order from three values alone, finest last; none where they do not converge monotonically.
std::optional<double> order_of_three(double coarse, double middle, double fine) {
  const double before = middle - coarse, after = fine - middle;
  if (before * after <= 0 || std::abs(after) >= std::abs(before)) return std::nullopt;
  const double order = std::log(before / after) / std::log(kRatio);
  return order < kLeastOrder ? std::nullopt : std::optional(order);
}

}  // namespace

double SteadyPlunge::torque_nmm() const {
  return specific_energy(density_g_cm3) * removal_mm3_s() / angular_speed(rpm);
}

double SteadyPlunge::axial_force_n() const {
  const double u = specific_energy(density_g_cm3), per_radian = feed_mm_s / angular_speed(rpm);
  return 2 * pi * kNormalRatio * u * per_radian * (face_integral(*this, outer_mm) - face_integral(*this, bore_mm)) +
         2 * pi * u * per_radian * per_radian * std::log(outer_mm / bore_mm);
}

double SteadyPlunge::ratio_mm() const {
  return (outer_mm * outer_mm - bore_mm * bore_mm) /
         (2 * kNormalRatio * (face_integral(*this, outer_mm) - face_integral(*this, bore_mm)));
}

PlungeLoads SteadyPlunge::full_loads() const {
  const HalfFaceLoads half = full_half_face();
  return {2 * half.torque_nmm, 2 * half.axial_force_n};
}

HalfFaceLoads SteadyPlunge::half_face() const {
  const double per_mm = specific_energy(density_g_cm3) * feed_mm_s / angular_speed(rpm);
  const double squares = outer_mm * outer_mm - bore_mm * bore_mm;
  const double flat = outer_mm - bore_mm, bent = face_integral(*this, outer_mm) - face_integral(*this, bore_mm);
  return {.torque_nmm = torque_nmm() / 2,
          .axial_force_n = axial_force_n() / 2,
          .along_e_n = radius_mm ? -kNormalRatio * per_mm * squares / *radius_mm : 0,
          .along_t_n = 2 * per_mm * flat,
          .about_e_nmm = radius_mm ? -2 * per_mm * *radius_mm * (flat - bent) : 0,
          .about_t_nmm = -kNormalRatio * per_mm * squares};
}

HalfFaceLoads SteadyPlunge::full_half_face() const {
  constexpr int kParts = 2000;  // of Simpson's rule; even
  const double u = specific_energy(density_g_cm3), omega = angular_speed(rpm);
  HalfFaceLoads sum;
  for (int i = 0; i <= kParts; ++i) {
    const double r = bore_mm + (outer_mm - bore_mm) * i / kParts;
    // −n_z and n_r of the face, and its height.
    const double slope = radius_mm ? std::sqrt(1 - r * r / (*radius_mm * *radius_mm)) : 1;
    const double radial = radius_mm ? r / *radius_mm : 0, z = radius_mm ? *radius_mm * (1 - slope) : 0;
    const double speed = std::hypot(omega * r, feed_mm_s);
    // F_t of a ring dr per radian; its components along the rotation, outwards and along the axis. n·v̂ = v_f·slope/|v|.
    const double per_radian = u * feed_mm_s * r / speed, into = feed_mm_s * slope / speed;
    const double spin = per_radian * (omega * r / speed) * (1 - kNormalRatio * into);
    const double outward = -kNormalRatio * per_radian * radial;
    const double axial = per_radian * (feed_mm_s / speed + kNormalRatio * (slope - into * feed_mm_s / speed));
    const double weight = i == 0 || i == kParts ? 1 : i % 2 == 1 ? 4 : 2;
    sum.torque_nmm += weight * pi * r * spin;
    sum.axial_force_n += weight * pi * axial;
    // ∫cos φ dφ = 2 over the half; the same with sin is 0.
    sum.along_e_n += weight * 2 * outward;
    sum.along_t_n += weight * 2 * spin;
    sum.about_e_nmm += weight * -2 * z * spin;
    sum.about_t_nmm += weight * 2 * (z * outward - r * axial);
  }
  const double third = (outer_mm - bore_mm) / kParts / 3;
  for (double* load :
       {&sum.torque_nmm, &sum.axial_force_n, &sum.along_e_n, &sum.along_t_n, &sum.about_e_nmm, &sum.about_t_nmm}) {
    *load *= third;
  }
  return sum;
}

double SteadyPlunge::removal_mm3_s() const {
  return pi * (outer_mm * outer_mm - bore_mm * bore_mm) * feed_mm_s;
}

double SteadyPlunge::full_contact_mm() const {
  if (!radius_mm) return 0;
  return *radius_mm - std::sqrt(*radius_mm * *radius_mm - outer_mm * outer_mm);
}

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
  const auto thrust = [&](double feed, double depth) {
    return thrust_within(head, feed, std::sqrt(2 * *head.radius_mm * depth - depth * depth));
  };
  const auto feed_at = [&](double depth) {
    return root([&](double feed) { return thrust(feed, depth); }, thrust_n, max_feed_mm_s);
  };
  // The feed is limited at first; the square root makes the integrand smooth.
  const double limited_mm = root([&](double depth) { return thrust(max_feed_mm_s, depth); }, thrust_n, depth_mm);
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

std::optional<double> observed_order(const std::vector<Level>& levels) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const Level& level : levels) {
    if (!level.error || std::abs(*level.error) < kRoundingError) continue;
    const double x = std::log(level.step), y = std::log(std::abs(*level.error));
    n += 1;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  if (n < 2) return std::nullopt;
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

GridIndex grid_index(const std::vector<Level>& levels, double formal_order) {
  const std::size_t n = levels.size();
  const double fine = levels[n - 1].found, after = std::abs(fine - levels[n - 2].found);
  GridIndex out{.fraction = 0, .safety_factor = kSafetyOfTwo, .order = {}};
  double difference = after, order = formal_order;
  if (n >= 3) {
    difference = std::max(after, std::abs(levels[n - 2].found - levels[n - 3].found));
    out.order = order_of_three(levels[n - 3].found, levels[n - 2].found, fine);
  }
  if (out.order) {
    out.safety_factor = kSafetyOfThree;
    order = std::min(*out.order, formal_order);
    difference = after;
  }
  out.fraction = out.safety_factor * difference / (std::abs(fine) * (std::pow(kRatio, order) - 1));
  return out;
}

void finish(Refinement& refinement) {
  refinement.order = observed_order(refinement.levels);
  refinement.index = grid_index(refinement.levels, kFormalOrder);
}

}  // namespace reamsim::verify
