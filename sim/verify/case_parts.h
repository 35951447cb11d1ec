// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <random>

#include "sim/verify/closed_forms.h"
#include "sim/verify/reaming.h"

namespace reamsim::verify {

// The cases; see docs/verification.md for what each shows.
CaseFindings half_space_case(const Setting& setting);
CaseFindings tilted_cap_case(const Setting& setting);
CaseFindings cylinder_case(const Setting& setting);
CaseFindings sweep_case(const Setting& setting);
CaseFindings layered_case(const Setting& setting);
CaseFindings steady_case(const Setting& setting);
CaseFindings ratio_case(const Setting& setting);
CaseFindings half_face_case(const Setting& setting);
CaseFindings ripple_case(const Setting& setting);
CaseFindings zero_feed_case(const Setting& setting);
CaseFindings retraction_case(const Setting& setting);
CaseFindings second_pass_case(const Setting& setting);
CaseFindings mirrored_case(const Setting& setting);
CaseFindings moved_case(const Setting& setting);
CaseFindings rotated_case(const Setting& setting);
CaseFindings time_step_case(const Setting& setting);
CaseFindings voxel_case(const Setting& setting);
CaseFindings energy_case(const Setting& setting);
CaseFindings push_steady_case(const Setting& setting);
CaseFindings push_ball_case(const Setting& setting);
CaseFindings push_mass_case(const Setting& setting);
CaseFindings push_stall_case(const Setting& setting);
CaseFindings push_energy_case(const Setting& setting);
CaseFindings compliance_steady_case(const Setting& setting);
CaseFindings compliance_half_case(const Setting& setting);
CaseFindings compliance_stiff_case(const Setting& setting);
CaseFindings compliance_energy_case(const Setting& setting);
CaseFindings ct_uniform_case(const Setting& setting);
CaseFindings ct_ramp_case(const Setting& setting);
CaseFindings ct_plate_case(const Setting& setting);
CaseFindings ct_force_case(const Setting& setting);

/// A figure of one run.
struct Sample {
  double expected = 0;
  double found = 0;
};

/// A level of a refinement from its runs, whose closed forms may differ a little from `nominal`.
inline Level level_of(double step, const std::vector<Sample>& samples, double nominal) {
  Level level{.step = step, .runs = static_cast<int>(samples.size())};
  std::vector<double> errors;
  for (const Sample& sample : samples) {
    errors.push_back(sample.found / sample.expected - 1);
    level.found += nominal * sample.found / sample.expected / static_cast<double>(samples.size());
  }
  level.error = samples.size() == 1 ? errors.front() : rms(errors);
  return level;
}

/// Adds the level of one run.
inline void add_level(Refinement& refinement, double step, double found) {
  const double expected = *refinement.expected;
  refinement.levels.push_back(level_of(step, {{expected, found}}, expected));
}

/// A figure against its closed form.
inline Check relative_check(const std::string& quantity, const std::string& unit, double expected, double found,
                            double tolerance, const std::string& reason) {
  return {quantity, unit, Measure::relative, expected, found, tolerance, reason};
}

/// Four voxel sizes, coarsest first, mm.
inline std::vector<double> four_voxels(double finest_mm) {
  return {8 * finest_mm, 4 * finest_mm, 2 * finest_mm, finest_mm};
}

/// The finest level against its closed form; of several runs the root mean square of their errors.
inline Check finest_check(const Refinement& refinement, double tolerance, const std::string& reason) {
  const Level& finest = refinement.levels.back();
  const std::string where =
      refinement.quantity + (refinement.step.starts_with("voxel") ? ", finest voxels" : ", shortest frames");
  if (finest.runs == 1) {
    return {where, refinement.unit, Measure::relative, *refinement.expected, finest.found, tolerance, reason};
  }
  return {"RMS error of the " + where, "", Measure::at_most, tolerance, *finest.error, 0, reason};
}

/// Torque, axial force and removal rate of a steady plunge, without levels.
inline std::vector<Refinement> load_refinements(const SteadyPlunge& plunge) {
  const PlungeLoads loads = plunge.full_loads();
  return {{"torque", "N·mm", "voxel, mm", loads.torque_nmm},
          {"axial force", "N", "voxel, mm", loads.axial_force_n},
          {"removal rate", "mm³/s", "voxel, mm", plunge.removal_mm3_s()}};
}

/// Finishes the refinement, checks its finest level and adds both to `out`.
inline void add_refinement(CaseFindings& out, Refinement refinement, double tolerance, const std::string& reason) {
  finish(refinement);
  out.checks.push_back(finest_check(refinement, tolerance, reason));
  out.refinements.push_back(std::move(refinement));
}

/// Random offsets from a seed.
class Offsets {
 public:
  explicit Offsets(unsigned seed) : random_(seed) {}
  /// Each component within ±step/2.
  Vec3 draw(double step_mm) {
    std::uniform_real_distribution<double> u(-0.5, 0.5);
    const double x = u(random_), y = u(random_), z = u(random_);
    return step_mm * Vec3(x, y, z);
  }

 private:
  std::mt19937 random_;
};

}  // namespace reamsim::verify
