// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <CLI/CLI.hpp>
#include <memory>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/environment.h"
#include "sim/base/error.h"
#include "sim/device/opencl.h"

namespace reamsim {

namespace {

std::string line(const cl::DeviceInfo& device, cl_device_id chosen) {
  std::string out = fmt::format("{} {}  [{}, driver {}, {}, {} compute units, {} MB, largest allocation {} MB]",
                                device.id == chosen ? "*" : " ", device.name, device.platform_name, device.driver,
                                device.gpu ? "GPU" : "CPU", device.compute_units,
                                device.global_memory_bytes / 1'000'000, device.max_allocation_bytes / 1'000'000);
  if (!device.missing.empty()) out += "  not usable: missing " + device.missing;
  return out;
}

/// The device that `auto` selects, and why; no device where none is usable.
struct Choice {
  cl_device_id id = nullptr;
  std::string name;
  std::string why;
};

Choice automatic_choice() {
  try {
    const cl::DeviceInfo device = cl::choose_device("auto");
    return {device.id, device.name,
            std::string("the first ") + (device.gpu ? "GPU" : "CPU") +
                " with 64-bit floats and 64-bit atomics; GPUs are preferred to CPUs"};
  } catch (const RunError& error) {
    return {nullptr, "", error.what()};
  }
}

void devices_command(const Console& console) {
  const auto kernels = prepare_opencl("auto", console);
  const auto devices = cl::list_devices();
  if (devices.empty()) {
    console.say("no OpenCL device found: install a driver (Debian: pocl-opencl-icd), or use --device serial (slow)");
    return;
  }
  const Choice choice = automatic_choice();
  for (const auto& device : devices) console.say(line(device, choice.id));
  console.say("auto selects " + (choice.name.empty() ? "" : choice.name + ": ") + choice.why);
  console.say("serial is always available: the reference in plain C++ (slow)");
}

using Json = nlohmann::ordered_json;

Json json_of(const cl::DeviceInfo& device, const Choice& choice) {
  return {{"name", device.name},
          {"platform", device.platform_name},
          {"driver", device.driver},
          {"type", device.gpu ? "gpu" : "cpu"},
          {"compute_units", device.compute_units},
          {"memory_bytes", device.global_memory_bytes},
          {"largest_allocation_bytes", device.max_allocation_bytes},
          {"missing", device.missing},
          {"selected", device.id == choice.id}};
}

void print_devices_as_json(const Console& console) {
  const auto kernels = prepare_opencl("auto", console);
  const Choice choice = automatic_choice();
  Json devices = Json::array();
  for (const auto& device : cl::list_devices()) devices.push_back(json_of(device, choice));
  print_json({{"program", "reamsim " REAMSIM_VERSION},
              {"ok", true},
              {"mistakes", Json::array()},
              {"auto", choice.name.empty() ? Json() : Json(choice.name)},
              {"why", choice.why},
              {"devices", devices}});
}

}  // namespace

void add_devices_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("devices", "List OpenCL devices and mark the one that `auto` selects");
  auto json = std::make_shared<bool>(false);
  command->add_flag("--json", *json, "Print one JSON document");
  command->callback(
      [json, &console] { *json ? run_with_json(console, print_devices_as_json) : devices_command(console); });
}

}  // namespace reamsim
