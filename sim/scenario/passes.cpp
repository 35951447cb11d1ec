// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/passes.h"

#include <string_view>
#include <utility>

namespace reamsim {

std::vector<PassSpec> passes_of(const Scenario& scenario) {
  if (scenario.motion.passes.empty()) return {{scenario.tool, scenario.motion, "tool", "motion"}};
  std::vector<PassSpec> out;
  for (std::size_t i = 0; i < scenario.motion.passes.size(); ++i) {
    const PassSettings& pass = scenario.motion.passes[i];
    const std::string key = "motion.passes." + std::to_string(i);
    PassSpec spec{pass.tool.value_or(scenario.tool), scenario.motion, pass.tool ? key + ".tool" : "tool", key};
    spec.motion.passes.clear();
    spec.motion.plunge = pass.plunge;
    out.push_back(spec);
  }
  return out;
}

namespace {

std::string key_in_pass(const PassSpec& pass, const std::string& key) {
  constexpr std::string_view kTool = "tool.", kMotion = "motion.", kPlunge = "motion.plunge";
  if (key.starts_with(kTool)) return pass.tool_key + "." + key.substr(kTool.size());
  if (key.starts_with(kPlunge)) return pass.motion_key + "." + key.substr(kMotion.size());
  return key;
}

}  // namespace

InputError in_pass(const PassSpec& pass, const InputError& error) {
  std::vector<Mistake> mistakes = error.mistakes();
  for (Mistake& mistake : mistakes) mistake.key = key_in_pass(pass, mistake.key);
  return InputError(std::move(mistakes));
}

}  // namespace reamsim
