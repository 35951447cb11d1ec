// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cmath>
#include <random>

#include "sim/record/verification.h"
#include "sim/verify/scene.h"

namespace reamsim::verify {

struct Report;
/// Runs a case and reports what it found.
using CaseRun = void(const Setting& setting, Report& out);

/// A scene with a closed-form solution or an invariant.
struct Case {
  const char* id = nullptr;
  CaseRun* run = nullptr;
  double seconds = 1;          ///< of the quick suite on two cores; only their ratios count
  bool of_device = false;      ///< needs an OpenCL device
  bool of_full_suite = false;  ///< not in the quick suite

  [[nodiscard]] bool belongs_to(const Setting& setting) const {
    return !(of_device && setting.device == "serial") && !(of_full_suite && setting.quick);
  }
  /// Throws InputError when there is no such device, RunError, Interrupted.
  [[nodiscard]] CaseFindings findings(const Setting& setting) const;
};

/// All cases, in the order of the report.
const std::vector<Case>& cases();

/// Runs every case that belongs to the setting. Throws as Case::findings().
Findings run_suite(const Setting& setting);

// What cases are made of.

// The cases; see docs/verification.md for what each shows.
CaseRun half_space_case, tilted_cap_case, cylinder_case, sweep_case, layered_case, steady_case, ratio_case,
    half_face_case, ripple_case, zero_feed_case, retraction_case, second_pass_case, mirrored_case, moved_case,
    rotated_case, time_step_case, voxel_case, energy_case, push_steady_case, push_ball_case, push_mass_case,
    push_stall_case, push_energy_case, compliance_steady_case, compliance_half_case, compliance_stiff_case,
    compliance_energy_case, ct_uniform_case, ct_ramp_case, ct_plate_case, ct_force_case, engines_case, speed_case;

/// A figure of one run.
struct Sample {
  double expected = 0;
  double found = 0;
};

/// A level of a refinement from its runs, whose closed forms may differ a little from `nominal`.
inline Level level_of(double step, const std::vector<Sample>& samples, double nominal) {
  Level level{.step = step, .runs = static_cast<int>(samples.size())};
  double error = 0, squares = 0;
  for (const Sample& sample : samples) {
    error = sample.found / sample.expected - 1;
    squares += error * error;
    level.found += nominal * sample.found / sample.expected / static_cast<double>(samples.size());
  }
  level.error = samples.size() == 1 ? error : std::sqrt(squares / static_cast<double>(samples.size()));
  return level;
}

/// Energy and volume of removed bone.
struct Removed {
  double energy_mj = 0;
  double volume_mm3 = 0;

  [[nodiscard]] double per_mm3() const { return energy_mj / volume_mm3; }
};

/// Adds the level of one run.
inline void add_level(Refinement& refinement, double step, double found) {
  const double expected = *refinement.expected;
  refinement.levels.push_back(level_of(step, {{expected, found}}, expected));
}

/// Four voxel sizes, coarsest first, mm.
inline std::vector<double> four_voxels(double finest_mm) {
  return {8 * finest_mm, 4 * finest_mm, 2 * finest_mm, finest_mm};
}

inline constexpr const char* kProjectLimit = "limit set by this project";

/// The findings of a case while it runs, with a function for each measure of a check.
struct Report : CaseFindings {
  void add(Measure measure, const std::string& quantity, const std::string& unit, double expected, double found,
           double tolerance, const std::string& reason) {
    checks.push_back({quantity, unit, measure, expected, found, tolerance, reason});
  }
  void relative(const std::string& quantity, const std::string& unit, double expected, double found, double tolerance,
                const std::string& reason = kProjectLimit) {
    add(Measure::relative, quantity, unit, expected, found, tolerance, reason);
  }
  void absolute(const std::string& quantity, const std::string& unit, double expected, double found, double tolerance,
                const std::string& reason = kProjectLimit) {
    add(Measure::absolute, quantity, unit, expected, found, tolerance, reason);
  }
  void at_least(const std::string& quantity, const std::string& unit, double limit, double found,
                const std::string& reason = kProjectLimit) {
    add(Measure::at_least, quantity, unit, limit, found, 0, reason);
  }
  void at_most(const std::string& quantity, const std::string& unit, double limit, double found,
               const std::string& reason = kProjectLimit) {
    add(Measure::at_most, quantity, unit, limit, found, 0, reason);
  }
  void reported(const std::string& quantity, const std::string& unit, double found, const std::string& reason = "") {
    add(Measure::reported, quantity, unit, 0, found, 0, reason);
  }

  /// Adds the refinement, and checks its finest level against the closed form; of several runs the root mean square of
  /// their errors.
  void refinement(Refinement refined, double tolerance, const std::string& reason = kProjectLimit) {
    finish(refined);
    const Level& finest = refined.levels.back();
    const std::string where =
        refined.quantity + (refined.step.starts_with("voxel") ? ", finest voxels" : ", shortest frames");
    if (finest.runs == 1) {
      relative(where, refined.unit, *refined.expected, finest.found, tolerance, reason);
    } else {
      at_most("RMS error of the " + where, "", tolerance, *finest.error, reason);
    }
    refinements.push_back(std::move(refined));
  }
};

/// Torque, axial force and removal rate of a steady plunge, without levels.
inline std::vector<Refinement> load_refinements(const SteadyPlunge& plunge) {
  const PlungeLoads loads = plunge.full_loads();
  return {{"torque", "N·mm", "voxel, mm", loads.torque_nmm},
          {"axial force", "N", "voxel, mm", loads.axial_force_n},
          {"removal rate", "mm³/s", "voxel, mm", plunge.removal_mm3_s()}};
}

/// A random offset: each component within ±step/2.
inline Vec3 draw_offset(std::mt19937& random, double step_mm) {
  std::uniform_real_distribution<double> u(-0.5, 0.5);
  const double x = u(random), y = u(random), z = u(random);
  return step_mm * Vec3(x, y, z);
}

}  // namespace reamsim::verify
