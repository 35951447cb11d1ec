#include <fmt/core.h>
#include <CLI/CLI.hpp>

#include "cli/commands.h"
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

void devices_command(const Console& console) {
  const auto kernels = prepare_opencl("auto", console);
  const auto devices = cl::list_devices();
  if (devices.empty()) {
    console.say("no OpenCL device found: install a driver (Debian: pocl-opencl-icd), or use --device serial (slow)");
    return;
  }
  std::string why;
  cl_device_id chosen = nullptr;
  try {
    const cl::DeviceInfo device = cl::choose_device("auto");
    chosen = device.id;
    why = device.name + ": the first " + (device.gpu ? "GPU" : "CPU") +
          " with 64-bit floats and 64-bit atomics; GPUs are preferred to CPUs";
  } catch (const RunError& error) {
    why = error.what();
  }
  for (const auto& device : devices) console.say(line(device, chosen));
  console.say("auto selects " + why);
  console.say("serial is always available: the reference in plain C++ (slow)");
}

}  // namespace

void add_devices_command(CLI::App& app, Console& console) {
  auto* command = app.add_subcommand("devices", "List OpenCL devices and mark the one that `auto` selects");
  command->callback([&console] { devices_command(console); });
}

}  // namespace reamsim
