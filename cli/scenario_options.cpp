#include <CLI/CLI.hpp>

#include "cli/commands.h"

namespace reamsim {

void ScenarioOptions::add_to(CLI::App& command) {
  command.add_option("SCENARIO", file, "Scenario file (YAML)")->required();
  command.add_option("--set", overrides, "Override a key of the scenario, for example bone.voxel_mm=0.4; repeatable")
      ->type_name("KEY.PATH=VALUE")
      ->expected(1)
      ->take_all();
  command.add_option("--device", device, "auto, serial, or part of the name of an OpenCL device")->type_name("NAME");
  command.add_option("--engine", engine, "Engine: bricked, direct, octree or implicit")->type_name("E");
}

std::vector<std::string> ScenarioOptions::all_overrides() const {
  std::vector<std::string> all = overrides;
  if (!device.empty()) all.push_back("engine.device=" + device);
  if (!engine.empty()) all.push_back("engine.detector=" + engine);
  return all;
}

}  // namespace reamsim
