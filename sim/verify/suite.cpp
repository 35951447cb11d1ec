// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/verify/suite.h"

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"

namespace reamsim::verify {

const std::vector<Case>& cases() {
  static const std::vector<Case> all = {
      {"half_space", half_space_case, 1.8},
      {"tilted_cap", tilted_cap_case, 6.3},
      {"cylinder", cylinder_case, 3.7},
      {"sweep", sweep_case, 0.6},
      {"layered", layered_case, 1.1},
      {"steady", steady_case, 1.9},
      {"ratio", ratio_case, 0.9},
      {"half_face", half_face_case, 1.1},
      {"ripple", ripple_case, 2.0},
      {"zero_feed", zero_feed_case, 0.1},
      {"retraction", retraction_case, 0.2},
      {"second_pass", second_pass_case, 0.2},
      {"mirrored", mirrored_case, 0.3},
      {"moved", moved_case, 0.2},
      {"rotated", rotated_case, 0.7},
      {"time_step", time_step_case, 1.1},
      {"voxel", voxel_case, 0.7},
      {"energy", energy_case, 0.1},
      {"push_steady", push_steady_case, 8.7},
      {"push_ball", push_ball_case, 1.5},
      {"push_mass", push_mass_case, 0.8},
      {"push_stall", push_stall_case, 3.3},
      {"push_energy", push_energy_case, 2.2},
      {"compliance_steady", compliance_steady_case, 1.2},
      {"compliance_half", compliance_half_case, 0.4},
      {"compliance_stiff", compliance_stiff_case, 1.0},
      {"compliance_energy", compliance_energy_case, 0.7},
      {"ct_uniform", ct_uniform_case, 1.8},
      {"ct_ramp", ct_ramp_case, 3.3},
      {"ct_plate", ct_plate_case, 2.9},
      {"ct_force", ct_force_case, 1.1},
      {"engines", engines_case, 2.0, true},
      {"speed", speed_case, 20.0, true, true},
  };
  return all;
}

CaseFindings Case::findings(const Setting& setting) const {
  if (setting.stop()) throw Interrupted();
  const Stopwatch watch;
  Report out;
  out.id = id;
  run(setting, out);
  out.seconds = watch.seconds();
  return out;
}

Findings run_suite(const Setting& setting) {
  const Stopwatch watch;
  Findings out;
  out.quick = setting.quick;
  const bool serial = setting.device == "serial";
  out.capabilities =
      serial ? Capabilities{{"device", "serial"}} : cl::capabilities_of(cl::choose_device(setting.device));
  double all = 0, past = 0;
  for (const Case& known : cases()) all += known.belongs_to(setting) ? known.seconds : 0;
  for (const Case& known : cases()) {
    if (!known.belongs_to(setting)) continue;
    setting.part(past / all, known.id);
    (known.of_device ? out.device_cases : out.cases).push_back(known.findings(setting));
    past += known.seconds;
  }
  setting.part(1, "");
  out.seconds = watch.seconds();
  return out;
}

}  // namespace reamsim::verify
