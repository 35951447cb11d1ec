// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/identify.h"

#include "sim/base/error.h"
#include "sim/scenario/parse.h"
#include "sim/study/run_id.h"

namespace reamsim {

Scenario scenario_of(const Study& study, const PlannedRun& run) {
  Scenario scenario = parse_scenario(study.base, run.overrides);
  // What is not kept is not made. The bytes of the rest do not depend on it.
  if (!study.keep.pictures) {
    scenario.render.enabled = false;
    scenario.output.meshes = false;
  }
  if (!study.keep.grids) scenario.output.vti = false;
  return scenario;
}

std::vector<IdentifiedRun> identify_runs(const Study& study, const StudyPlan& plan,
                                         const std::function<void(std::size_t)>& done) {
  Checksums checksums;
  std::vector<IdentifiedRun> out;
  for (const PlannedRun& run : plan.runs) {
    try {
      out.push_back({run_id(scenario_of(study, run), study.keep, checksums), ""});
    } catch (const InputError& error) {
      out.push_back({"", (run.place.empty() ? "" : run.place + ": ") + message_of(error)});
    }
    if (done) done(out.size());
  }
  return out;
}

}  // namespace reamsim
