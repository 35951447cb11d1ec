// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/identify.h"

#include <algorithm>
#include <iterator>
#include <map>

#include "sim/base/error.h"
#include "sim/scenario/parse.h"
#include "sim/study/run_id.h"

namespace reamsim {

namespace {

constexpr std::size_t kMostGroups = 3, kMostNumbers = 5;

/// "3, 5 and 7"; of many the first ones.
std::string numbers_text(const std::vector<std::size_t>& rows) {
  const std::size_t shown = rows.size() <= kMostNumbers ? rows.size() - 1 : kMostNumbers;
  std::string out;
  for (std::size_t i = 0; i < shown; ++i) out += (i == 0 ? "" : ", ") + std::to_string(rows[i] + 1);
  return out + " and " +
         (shown + 1 == rows.size() ? std::to_string(rows.back() + 1) : std::to_string(rows.size() - shown) + " more");
}

/// The mistakes of the scenario that are not those of keys whose cells were refused: these keys have the value of the
/// base scenario, or none.
std::vector<Mistake> further_mistakes(const PlannedRun& run, const InputError& error) {
  MistakeList refused;
  if (!run.mistakes.empty()) refused.add(InputError(run.mistakes));
  std::vector<Mistake> out;
  std::ranges::copy_if(error.mistakes(), std::back_inserter(out),
                       [&](const Mistake& mistake) { return !refused.concerns(mistake.key); });
  return out;
}

/// All mistakes on one line, with the place of the row first.
std::string text_of(const PlannedRun& run, const std::vector<Mistake>& further) {
  std::string out;
  for (const Mistake& mistake : run.mistakes) out += (out.empty() ? "" : " | ") + mistake.line();
  const std::string place = out.empty() && !run.place.empty() ? run.place + ": " : "";
  for (const Mistake& mistake : further) out += (out.empty() ? place : " | ") + mistake.line();
  return out;
}

IdentifiedRun identified(const Study& study, const PlannedRun& run, Checksums& checksums) {
  try {
    const Scenario scenario = scenario_of(study, run);
    if (run.mistakes.empty()) return {run_id(scenario, study.keep, checksums), ""};
    return {"", text_of(run, {})};
  } catch (const InputError& error) {
    return {"", text_of(run, further_mistakes(run, error))};
  }
}

}  // namespace

std::vector<std::size_t> rows_of_run(const std::vector<IdentifiedRun>& runs, std::size_t run) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (runs[i].id == runs[run].id) out.push_back(i);
  return out;
}

std::vector<std::string> same_runs(const std::vector<IdentifiedRun>& runs) {
  std::map<std::string, std::vector<std::size_t>> rows_of;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (!runs[i].id.empty()) rows_of[runs[i].id].push_back(i);
  std::vector<std::string> out;
  std::size_t groups = 0;
  for (const IdentifiedRun& run : runs) {
    const auto found = rows_of.find(run.id);
    if (found == rows_of.end()) continue;
    if (found->second.size() > 1 && ++groups <= kMostGroups)
      out.push_back("runs " + numbers_text(found->second) + " are the same run, which is simulated once");
    rows_of.erase(found);
  }
  if (groups > kMostGroups) out.push_back(std::to_string(groups - kMostGroups) + " more runs are given twice");
  return out;
}

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
    out.push_back(identified(study, run, checksums));
    if (done) done(out.size());
  }
  return out;
}

}  // namespace reamsim
