// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <sstream>
#include <tuple>

#include "cli/commands.h"
#include "cli/input_kind.h"
#include "sim/base/error.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

constexpr const char* kTuningVariable = "REAMSIM_ENGINE_TUNING";

/// Sets one member from "name=value"; false where the text is none of them.
bool set_tuning(EngineTuning& tuning, const std::string& text) {
  const std::string name = text.substr(0, text.find('='));
  const std::string value = name.size() < text.size() ? text.substr(name.size() + 1) : "";
  if (name == "kernel_shape" && from_name<KernelShape>(value)) {
    tuning.kernel_shape = *from_name<KernelShape>(value);
    return true;
  }
  for (const auto& [flag, member] : {std::pair{"culling", &tuning.culling}, std::pair{"windows", &tuning.windows}}) {
    if (name != flag || (value != "true" && value != "false")) continue;
    *member = value == "true";
    return true;
  }
  const char* const end = value.data() + value.size();
  return name == "work_group_size" && std::from_chars(value.data(), end, tuning.work_group_size).ptr == end &&
         tuning.work_group_size >= 0;
}

EngineTuning tuning_of_environment() {
  EngineTuning tuning;
  const char* const given = std::getenv(kTuningVariable);
  std::istringstream words(given == nullptr ? "" : given);
  for (std::string word; words >> word;) {
    if (!set_tuning(tuning, word)) {
      throw InputError(
          {}, kTuningVariable, "found " + word,
          "expected kernel_shape=auto|cpu|gpu, culling=true|false, windows=true|false or work_group_size=N");
    }
  }
  return tuning;
}

}  // namespace

void ScenarioOptions::add_to(CLI::App& command) {
  take_shipped_names(
      *command.add_option("SCENARIO", file, "Scenario file (YAML), or the name of a shipped one")->required(),
      ShippedKind::scenario);
  command.add_option("--set", overrides, "Override a key of the scenario, for example bone.voxel_mm=0.4; repeatable")
      ->type_name("KEY.PATH=VALUE")
      ->expected(1)
      ->take_all();
  command.add_option("--device", device, "auto, serial, or part of the name of an OpenCL device")->type_name("NAME");
  command.add_option("--engine", engine, "Engine (default: that of the scenario)")
      ->type_name("auto|exact|bricked|direct|octree|implicit");
}

Scenario ScenarioOptions::parse() const {
  std::vector<std::string> all = overrides;
  for (const auto& [option, value, key] :
       {std::tuple{"--device", &device, "engine.device="}, std::tuple{"--engine", &engine, "engine.type="}}) {
    const bool twice = !value->empty() && std::ranges::any_of(overrides, [prefix = key](const std::string& set) {
      return set.starts_with(prefix);
    });
    if (twice) throw InputError({}, option, std::string("given beside --set ") + key + "...", "give one of them");
  }
  if (!device.empty()) all.push_back("engine.device=" + device);
  if (!engine.empty()) all.push_back("engine.type=" + engine);
  Scenario scenario = parse_scenario(file, all);
  scenario.engine.tuning = tuning_of_environment();
  return scenario;
}

}  // namespace reamsim
