#pragma once

#include <optional>

#include "sim/scenario/scenario.h"

namespace reamsim::verify {

/// The law's constants as the suite states them, and not as the program's defaults happen to be.
inline constexpr double kSpecificEnergy_mj_mm3 = 150;  ///< at kReferenceDensity
inline constexpr double kReferenceDensity_g_cm3 = 1.8;
inline constexpr double kDensityExponent = 2;
inline constexpr double kNormalRatio = 0.5;
inline constexpr double kSpeedFloor_mm_s = 10;

/// Cutting settings with these constants and this erosion.
CuttingSettings stated_cutting(const std::string& erosion);

/// Specific cutting energy, mJ/mm³ (= N/mm²): u₀·(ρ/1.8)².
double specific_energy(double density_g_cm3);

double angular_speed(double rpm);  ///< rad/s

/// Volume of a spherical cap: π·d²·(R − d/3). d ≤ R.
double cap_mm3(double radius_mm, double depth_mm);
/// Area that a disc of radius R has beyond a chord at R − d from its centre.
double segment_mm2(double radius_mm, double depth_mm);

/// Torque against the spin and thrust out of the bone.
struct PlungeLoads {
  double torque_nmm = 0;
  double thrust_n = 0;
};

/// A cannulated reamer fed along its axis in full contact in uniform bone (design §5).
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
  [[nodiscard]] double thrust_n() const;
  /// The law's integral over the face by quadrature, which these two approach for v_f ≪ ωr: the spin's work is less by
  /// that of the feed, thrust·v_f.
  [[nodiscard]] PlungeLoads full_loads() const;
  /// π·(a² − r₀²)·v_f, mm³/s.
  [[nodiscard]] double removal_mm3_s() const;
  /// Depth from which on the face is in contact out to a, mm.
  [[nodiscard]] double full_contact_mm() const;
};

}  // namespace reamsim::verify
