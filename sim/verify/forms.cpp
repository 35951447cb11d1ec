#include "sim/verify/forms.h"

#include <cmath>
#include <numbers>

namespace reamsim::verify {

using std::numbers::pi;

CuttingSettings stated_cutting(const std::string& erosion) {
  CuttingSettings cutting;
  cutting.law = "energy";
  cutting.erosion = erosion;
  cutting.specific_energy_j_mm3 = kSpecificEnergy_mj_mm3 / 1000;
  cutting.reference_density_g_cm3 = kReferenceDensity_g_cm3;
  cutting.density_exponent = kDensityExponent;
  cutting.normal_ratio = kNormalRatio;
  cutting.speed_floor_mm_s = kSpeedFloor_mm_s;
  return cutting;
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

/// C(r) of the design: ∫ cos θ dr along the face from the axis to r, with θ the slope of the face.
double face_integral(const SteadyPlunge& plunge, double r) {
  if (!plunge.radius_mm) return r;
  const double radius = *plunge.radius_mm;
  return 0.5 * (r * std::sqrt(1 - r * r / (radius * radius)) + radius * std::asin(r / radius));
}

}  // namespace

double SteadyPlunge::torque_nmm() const {
  return specific_energy(density_g_cm3) * removal_mm3_s() / angular_speed(rpm);
}

double SteadyPlunge::thrust_n() const {
  const double u = specific_energy(density_g_cm3), per_radian = feed_mm_s / angular_speed(rpm);
  return 2 * pi * kNormalRatio * u * per_radian * (face_integral(*this, outer_mm) - face_integral(*this, bore_mm)) +
         2 * pi * u * per_radian * per_radian * std::log(outer_mm / bore_mm);
}

PlungeLoads SteadyPlunge::full_loads() const {
  constexpr int kParts = 2000;  // of Simpson's rule; even
  const double u = specific_energy(density_g_cm3), omega = angular_speed(rpm);
  PlungeLoads sum;
  for (int i = 0; i <= kParts; ++i) {
    const double r = bore_mm + (outer_mm - bore_mm) * i / kParts;
    const double slope = radius_mm ? std::sqrt(1 - r * r / (*radius_mm * *radius_mm)) : 1;  // −n_z of the face
    const double speed = std::hypot(omega * r, feed_mm_s);
    // F_t of a ring dr, then its parts along the spin and the axis. n·v̂ = v_f·slope/|v|.
    const double tangential = u * feed_mm_s * 2 * pi * r / speed, into = feed_mm_s * slope / speed;
    const double weight = i == 0 || i == kParts ? 1 : i % 2 == 1 ? 4 : 2;
    sum.torque_nmm += weight * r * tangential * (omega * r / speed) * (1 - kNormalRatio * into);
    sum.thrust_n += weight * tangential * (feed_mm_s / speed + kNormalRatio * (slope - into * feed_mm_s / speed));
  }
  const double third = (outer_mm - bore_mm) / kParts / 3;
  return {sum.torque_nmm * third, sum.thrust_n * third};
}

double SteadyPlunge::removal_mm3_s() const {
  return pi * (outer_mm * outer_mm - bore_mm * bore_mm) * feed_mm_s;
}

double SteadyPlunge::full_contact_mm() const {
  if (!radius_mm) return 0;
  return *radius_mm - std::sqrt(*radius_mm * *radius_mm - outer_mm * outer_mm);
}

}  // namespace reamsim::verify
