#include "sim/verify/suite.h"

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/verify/case_parts.h"

namespace reamsim::verify {

namespace {

CaseFindings timed(const Case& chosen, const Setting& setting) {
  if (setting.stop()) throw Interrupted();
  const Stopwatch watch;
  CaseFindings out = chosen.run(setting);
  out.id = chosen.id;
  out.seconds = watch.seconds();
  return out;
}

}  // namespace

const std::vector<Case>& cases() {
  static const std::vector<Case> all = {
      {"half_space", half_space_case},
      {"tilted_cap", tilted_cap_case},
      {"cylinder", cylinder_case},
      {"sweep", sweep_case},
      {"layered", layered_case},
      {"steady", steady_case},
      {"ratio", ratio_case},
      {"half_face", half_face_case},
      {"ripple", ripple_case},
      {"zero_feed", zero_feed_case},
      {"retraction", retraction_case},
      {"second_pass", second_pass_case},
      {"mirrored", mirrored_case},
      {"moved", moved_case},
      {"rotated", rotated_case},
      {"time_step", time_step_case},
      {"voxel", voxel_case},
      {"energy", energy_case},
      {"push_steady", push_steady_case},
      {"push_ball", push_ball_case},
      {"push_mass", push_mass_case},
      {"push_stall", push_stall_case},
      {"push_energy", push_energy_case},
      {"compliance_steady", compliance_steady_case},
      {"compliance_half", compliance_half_case},
      {"compliance_stiff", compliance_stiff_case},
      {"compliance_energy", compliance_energy_case},
      {"ct_uniform", ct_uniform_case},
      {"ct_ramp", ct_ramp_case},
      {"ct_plate", ct_plate_case},
      {"ct_force", ct_force_case},
  };
  return all;
}

CaseFindings run_case(const std::string& id, const Setting& setting) {
  for (const Case& known : cases()) {
    if (known.id == id) return timed(known, setting);
  }
  throw InputError("no verification case \"" + id + "\"");
}

Findings run_suite(const Setting& setting) {
  const Stopwatch watch;
  Findings out;
  out.quick = setting.quick;
  for (const Case& known : cases()) {
    setting.progress(known.id);
    out.cases.push_back(timed(known, setting));
  }
  out.seconds = watch.seconds();
  return out;
}

}  // namespace reamsim::verify
