// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "sim/record/verification.h"
#include "sim/scenario/scenario.h"

namespace reamsim::verify {

/// The constants of the law, independent of the program's defaults.
inline constexpr double kSpecificEnergy_mj_mm3 = 150;  ///< at kReferenceDensity
inline constexpr double kReferenceDensity_g_cm3 = 1.8;
inline constexpr double kDensityExponent = 2;
inline constexpr double kNormalRatio = 0.5;
inline constexpr double kSpeedFloor_mm_s = 10;

/// Cutting settings with these constants and this erosion.
CuttingSettings stated_cutting(ErosionMode erosion);

/// Specific cutting energy, mJ/mm³ (= N/mm²): u₀·(ρ/1.8)².
double specific_energy(double density_g_cm3);

double angular_speed(double rpm);  ///< rad/s

/// Volume of a spherical cap: π·d²·(R − d/3). d ≤ R.
double cap_mm3(double radius_mm, double depth_mm);
/// Area of a disc of radius R beyond a chord at R − d from its centre.
double segment_mm2(double radius_mm, double depth_mm);

/// Torque against the rotation, and axial force out of the bone.
struct PlungeLoads {
  double torque_nmm = 0;
  double axial_force_n = 0;
};

/// Loads of a face with bone under one half: towards e, perpendicular to the axis. t is e rotated by 90°,
/// counter-clockwise seen from the drive; the tool rotates clockwise (docs/scenario.md).
struct HalfFaceLoads {
  double torque_nmm = 0;     ///< against the rotation
  double axial_force_n = 0;  ///< out of the bone
  double along_e_n = 0;      ///< of the normal parts: away from the bone, so negative
  double along_t_n = 0;      ///< of the tangential parts
  double about_e_nmm = 0;    ///< moment about the tool's origin
  double about_t_nmm = 0;
};

/// A cannulated reamer fed along its axis in full contact in uniform bone (docs/physics.md, 6).
struct SteadyPlunge {
  std::optional<double> radius_mm = {};  ///< R of the spherical face; none: flat
  double outer_mm = 0;                   ///< a
  double bore_mm = 0;                    ///< r₀
  double rpm = 0;
  double feed_mm_s = 0;
  double density_g_cm3 = 1.8;

  /// π·u·(a² − r₀²)·v_f/ω, N·mm.
  [[nodiscard]] double torque_nmm() const;
  /// 2π·k_n·u·(v_f/ω)·[C(a) − C(r₀)] + 2π·u·(v_f/ω)²·ln(a/r₀), N.
  [[nodiscard]] double axial_force_n() const;
  /// The law's integral over the face by quadrature, which both approach for v_f ≪ ωr. The work of the rotation is less
  /// by that of the feed, F_z·v_f.
  [[nodiscard]] PlungeLoads full_loads() const;
  /// Torque over axial force for v_f ≪ ωr, mm: (a² − r₀²)/(2·k_n·[C(a) − C(r₀)]). Independent of density and energy.
  [[nodiscard]] double ratio_mm() const;
  /// With bone under half of the face: torque and axial force are half of the above;
  /// F·e = −k_n·u·(v_f/ω)·(a² − r₀²)/R (flat: 0), F·t = 2u·(v_f/ω)·(a − r₀);
  /// M·e = −2u·(v_f/ω)·R·[(a − r₀) − (C(a) − C(r₀))] (flat: 0), M·t = −k_n·u·(v_f/ω)·(a² − r₀²).
  [[nodiscard]] HalfFaceLoads half_face() const;
  /// The law's integral over the half face by quadrature, which these approach for v_f ≪ ωr.
  [[nodiscard]] HalfFaceLoads full_half_face() const;
  /// π·(a² − r₀²)·v_f, mm³/s.
  [[nodiscard]] double removal_mm3_s() const;
  /// Depth of full contact, mm.
  [[nodiscard]] double full_contact_mm() const;
};

// Feeds of a head under a thrust, from the closed forms of its forces (docs/feeds.md, 10). `feed_mm_s` of the head is
// not used.

/// A of A·v + B·v² = F, N·s/mm.
double linear_resistance(const SteadyPlunge& head);
/// The feed in full contact from A·v + B·v² = F, mm/s.
double quadratic_feed(const SteadyPlunge& head, double thrust_n);
/// The feed in full contact from all terms of the force, mm/s.
double balanced_feed_of(const SteadyPlunge& head, double thrust_n);
/// The time in which a head without bore comes from first contact to a depth below its full contact, s: the integral of
/// the inverse feed, which is that of the force on the cap in contact, with the law's speed floor.
double time_to_depth_s(const SteadyPlunge& head, double thrust_n, double max_feed_mm_s, double depth_mm);
/// The travel of a mass from rest in full contact, mm: M·dv/dt = F − A·v − B·v².
double travel_of_mass_mm(const SteadyPlunge& head, double thrust_n, double mass_kg, double time_s);

/// Errors below this are rounding of fills (16 bits) and positions (single precision). They do not show the convergence
/// of the method.
inline constexpr double kRoundingError = 1e-7;

/// Order p of an error that falls as step^p: the slope of log|error| over log step, by least squares over the levels
/// above kRoundingError. None with fewer than two of them.
std::optional<double> observed_order(const std::vector<Level>& levels);

/// The index of the finest of at least two levels, coarsest first; each step is half of the previous one.
/// `formal_order` caps the observed order. It replaces that where the last three levels do not converge monotonically;
/// then the larger of their differences counts.
GridIndex grid_index(const std::vector<Level>& levels, double formal_order);

/// Sets order and index from the levels. Plane clipping is of second order.
void finish(Refinement& refinement);

}  // namespace reamsim::verify
