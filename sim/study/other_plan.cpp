// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/other_plan.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

constexpr std::size_t kMostShown = 3;
/// Runs of the plan that are compared. Those of a larger plan differ from each other in what varies alone.
constexpr std::size_t kMostCompared = 200;

using Values = std::map<std::string, std::string>;

Values values_of(const std::string& yaml, const std::string& name) {
  const ScenarioValues all = values_of_scenario(*parse_yaml(yaml, name));
  return {all.begin(), all.end()};
}

std::string shown_value(const Values& values, const std::string& key) {
  const auto found = values.find(key);
  return found == values.end() ? "missing" : printable(found->second);
}

std::vector<std::string> differences_of(const Values& there, const Values& here) {
  std::set<std::string> keys;
  for (const Values* values : {&there, &here}) {
    for (const auto& [key, value] : *values) keys.insert(key);
  }
  std::vector<std::string> out;
  for (const std::string& key : keys) {
    const std::string found = shown_value(there, key), expected = shown_value(here, key);
    if (found != expected) out.push_back(fmt::format("{} is {} there and {} in this plan", key, found, expected));
  }
  return out;
}

/// Those to the most similar run of the plan.
std::vector<std::string> least_differences(const Values& there, const Study& study, const StudyPlan& plan,
                                           const std::vector<IdentifiedRun>& runs) {
  std::optional<std::vector<std::string>> least;
  for (std::size_t i = 0; i < std::min(runs.size(), kMostCompared); ++i) {
    if (runs[i].id.empty()) continue;
    std::vector<std::string> found =
        differences_of(there, values_of(to_yaml(scenario_of(study, plan.runs[i])), "plan"));
    if (!least || found.size() < least->size()) least = std::move(found);
  }
  return least.value_or(std::vector<std::string>{});
}

}  // namespace

OtherRuns find_other_runs(const Study& study, const StudyPlan& plan, const std::vector<IdentifiedRun>& runs,
                          const StudyFolder& folder) {
  std::set<std::string> own;
  for (const IdentifiedRun& run : runs) own.insert(run.id);
  std::vector<std::string> others = folder.run_names();
  std::erase_if(others, [&](const std::string& id) { return own.contains(id) || folder.state(id) != RunState::done; });
  OtherRuns out{.count = static_cast<int>(others.size()), .differences = {}};
  if (others.empty()) return out;
  const std::string file = folder.run_dir(others.front()) + "/scenario.yaml";
  try {
    out.differences = least_differences(values_of(read_file(file, "the scenario of a run"), file), study, plan, runs);
  } catch (const InputError&) {
    return out;  // damaged: the count stays true
  }
  out.differences.resize(std::min(out.differences.size(), kMostShown));
  return out;
}

std::string sentence_of(const OtherRuns& others, const std::string& dir) {
  if (others.count == 0) return "";
  const std::string begin =
      others.count == 1 ? fmt::format("1 result in {} belongs to another plan of this study", dir)
                        : fmt::format("{} results in {} belong to another plan of this study", others.count, dir);
  if (others.differences.empty()) {
    return begin + ": the version of the program, the contents of an input file or a key of output or render differs";
  }
  return fmt::format("{}: {}; give the same --set as for sweep run, or the same study", begin,
                     fmt::join(others.differences, ", "));
}

}  // namespace reamsim
